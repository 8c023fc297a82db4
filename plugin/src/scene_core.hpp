#pragma once

#include <tbb/task_arena.h>

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "explain.hpp"
#include "guarded.hpp"
#include "pair_selection.hpp"
#include "rank_exchange.hpp"
#include "scene_store.hpp"
#include "selected_detector.hpp"
#include "softcd/error.hpp"
#include "softcd/query.hpp"

namespace softcd::detail {

class ProbeCore;
class SceneCore;

constexpr const char* kNoMemoryAtAll = "memory ran out where hardly any is needed; free memory.";
constexpr const char* kNoMemoryForPairs = "memory ran out for a list of pairs of bodies. Free memory, or give fewer.";

/// A detection that nobody has waited for.
struct PendingDetection {
  std::uint64_t number = 0;
  DetectionInput input;
  Statistics statistics;
  Decisions decisions;
  bool has_work = false;  ///< of the detector's
  Span<const Contact> contacts;
  StayingContacts staying;  ///< where they do
  TestSamples tests;        ///< where it was one rank's
  std::exception_ptr problem;
};

/// What is behind a Query. It has at most one detection, which runs, is finished, or was waited for.
class QueryCore {
 public:
  QueryCore(std::shared_ptr<SceneCore> scene, const QueryOptions& options);
  QueryCore(const QueryCore&) = delete;
  QueryCore& operator=(const QueryCore&) = delete;
  ~QueryCore();

  /// The number of the detection.
  std::uint64_t start(Pairs pairs);
  Span<const Contact> wait(std::uint64_t number);
  DeviceContacts wait_on_device(std::uint64_t number);
  PendingContacts on_device(std::uint64_t number);
  /// Its query is gone.
  void close() noexcept;

  void set_options(const QueryOptions& options);
  const QueryOptions& options() const { return options_; }
  void set_pair_filter(PairFilter filter);
  void set_only_pairs(Span<const BodyPair> pairs);
  std::shared_ptr<const void> hold_contacts();
  std::vector<Contact> gather_contacts();
  const Statistics& statistics() const { return statistics_; }
  std::vector<StageReport> explain() const;

 private:
  friend class SceneCore;

  void end() noexcept;
  /// Throws Error when the scene is gone.
  void require_scene() const;
  void require_contacts_on_device() const;
  void require_unread(std::uint64_t number) const;
  PendingDetection finished(std::uint64_t number);
  QueryMemories& free_memories();

  std::shared_ptr<SceneCore> scene_;
  QueryOptions options_;
  PairFilter filter_;
  BodyPairList only_pairs_;  ///< none: all
  PairSelector pairs_;       ///< what it has selected is the last detection's
  /// The last detection's at the end, before them those that somebody holds.
  std::vector<std::shared_ptr<QueryMemories>> memories_;
  bool has_contacts_ = false;  ///< that were waited for, and are valid
  Span<const Contact> contacts_;
  std::uint64_t last_number_ = 0;
  std::uint64_t last_change_ = 0;  ///< of the scene, when the last detection was started
  std::optional<PendingDetection> detection_;
  Statistics statistics_;  ///< of the last detection that was waited for
  Decisions decisions_;
  bool is_closed_ = false;
};

/// What is behind a Scene.
class SceneCore {
 public:
  SceneCore(const SceneOptions& options, LogCallback log, DetectorFactories factories);

  BodyId add_body(const BodyDesc& desc);
  void update_body(BodyId id, const BodyDesc& desc);
  void update_body(BodyId id, const BodyDesc& desc, Span<const std::uint32_t> changed);
  void set_settings(BodyId id, const BodySettings& settings);
  void remove_body(BodyId id);
  bool has_body(BodyId id) { return store_->layout().find(id) != nullptr; }
  void set_positions(BodyId id, const Positions& x_t0, const Positions& x_t1, bool has_step_end = true);
  void set_ignored_pairs(Span<const BodyPair> pairs);
  void set_vertex_filters(BodyId id, Span<const VertexFilter> filters);
  void set_rest_positions(BodyId id, const Positions& x);
  void set_options(const SceneOptions& options);
  void set_log(LogCallback log) { log_ = std::move(log); }
  const SceneOptions& options() const { return options_; }
  Backend backend() const { return detector_->backend(); }
  /// Why there.
  std::string backend_reason() const { return is_closed_ ? "the scene is gone" : detector_->reason(); }
  /// That detections on CUDA run on.
  int cuda_device() { return detector_->position_reader().device(); }
  const SceneStore& store() const { return *store_; }

  void start(QueryCore& query, Pairs pairs);
  bool is_running(const QueryCore& query) const { return running_ == &query; }
  /// Waits for the detection that runs, if any; its query has its contacts, or what went wrong, then.
  void finish_running() noexcept;
  /// The same where what changes the scene, or a query, may change what it finds.
  void finish_foreseen() noexcept;
  /// Those that were not waited for.
  void drop_detections() noexcept;
  /// Ends what runs; there are no further detections.
  void close() noexcept;
  bool is_closed() const { return is_closed_; }
  /// Throws what has gone wrong in a detection that is not running any more, on any rank.
  void conclude(PendingDetection& detection);
  /// All ranks' contacts, in order.
  std::vector<Contact> gather(Span<const Contact> contacts);

  void enter(QueryCore& query) { queries_.push_back(&query); }
  void leave(const QueryCore& query) { std::erase(queries_, &query); }

  /// Once no detection runs.
  void answer(ProbeCore& probe, bool wants_sides, const Questions& ask);
  void enter(ProbeCore& probe) { probes_.push_back(&probe); }
  void leave(const ProbeCore& probe) { std::erase(probes_, &probe); }

 private:
  Body& find(BodyId id);
  void validate_rank(BodyId id, const BodyDesc& desc) const;
  void meet_ranks(const QueryOptions& options, Pairs pairs);
  void start_detector(QueryCore& query, PendingDetection& detection, Pairs pairs);
  std::unique_ptr<SelectedDetector> detector_for(const SceneOptions& options, DetectorFactories factories);
  void use(std::unique_ptr<SelectedDetector> detector);
  void finish_detector(QueryCore& query, PendingDetection& detection, Statistics& found);
  template <class F>
  static auto reading(const F& f);
  void settle(const LookedAt& by_next, bool may_foresee, bool lists_neighbours);
  bool judge_foreseen();
  bool may_foresee(const QueryCore& query, Pairs pairs) const;
  void prepare(QueryCore& query, PendingDetection& detection, Pairs pairs, bool may_foresee);
  ProbedScene probed_scene(ProbeCore& probe, bool wants_sides);
  PairFilter pair_filter(const QueryCore& query) const;
  void warn_of_missing_positions(const QueryOptions& options);
  void require_rest_positions() const;
  LookedAt looked_at() const;
  SceneSize count_elements(Statistics& statistics) const;
  void warn_of_strays() const;
  void log(LogLevel level, std::string_view message) const;
  template <class MemoryProblem, class F>
  void guarded_in_memory(Statistics& statistics, const MemoryProblem& memory_problem, const F& f);
  std::string preparation_problem() const;
  std::string detection_problem() const;
  std::string answer_problem() const;
  std::string where() const;

  SceneOptions options_;
  LogCallback log_;
  tbb::task_arena arena_;  ///< of our own, so that whoever waits works on nothing but this scene
  std::optional<SceneStore> store_{std::in_place};  ///< another one once the scene is closed
  std::unique_ptr<RankExchange> ranks_;             ///< null where there is one
  std::unique_ptr<SelectedDetector> detector_;
  std::vector<QueryCore*> queries_;
  std::vector<ProbeCore*> probes_;
  QueryCore* running_ = nullptr;
  bool is_closed_ = false;
  bool was_given_step_end_ = false;  ///< some body had both ends of a step
  bool has_warned_of_no_positions_ = false;
  bool has_warned_of_no_end_ = false;
};

}  // namespace softcd::detail
