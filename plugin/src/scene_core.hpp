#pragma once

#include <exception>
#include <functional>
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
#include "softcd/core/parallel.hpp"
#include "softcd/error.hpp"
#include "softcd/probe.hpp"
#include "softcd/query.hpp"

namespace softcd::detail {

constexpr const char* kNoMemoryAtAll = "memory ran out where hardly any is needed; free memory.";
constexpr const char* kNoMemoryForPairs = "memory ran out for a list of pairs of bodies. Free memory, or give fewer.";

/// A detection that the caller has not waited for yet.
struct PendingDetection {
  DetectionInput input;
  Statistics statistics;
  Decisions decisions;
  bool has_work = false;  ///< whether the detector has work to do
  Span<const Contact> contacts;
  StayingContacts staying;  ///< contacts that stay on the device, if they do
  TestSamples tests;        ///< of this rank, if there are several
  std::exception_ptr problem;
};

/// A query or a probe of a scene.
class SceneUser {
 public:
  SceneUser() = default;
  SceneUser(const SceneUser&) = delete;
  SceneUser& operator=(const SceneUser&) = delete;

  virtual NeededPositions needed_positions() const = 0;
  /// Returns memory for the next detection or results, which the caller does not hold.
  virtual QueryMemories& free_memories() = 0;
  virtual void drop_memories() noexcept = 0;
  /// Passes the running detection to SceneCore::finish().
  virtual void finish_detection() noexcept {}
  virtual void drop_detection() noexcept {}

 protected:
  ~SceneUser() = default;
};

/// A query's request to its scene. The references are the query's.
struct DetectionRequest {
  SceneUser& user;
  const QueryOptions& options;
  Pairs pairs;
  std::uint64_t last_change;  ///< number of the scene's last change when the query's last detection was started
  const PairFilter& filter;
  const BodyPairList& only_pairs;  ///< empty: all pairs
  PairSelector& selector;          ///< its selection belongs to the last detection
  Statistics& statistics;          ///< receives the memory counters when memory runs out
};

/// The parts of a scene that only some questions need.
struct ProbeNeeds {
  bool sides = false;            ///< of closed surfaces
  bool given_positions = false;  ///< where floats round them
};

/// A probe's request to its scene. The references are the probe's.
struct ProbeRequest {
  SceneUser& user;
  bool at_t0;
  ProbeNeeds needs;
  const BodyFilter& filter;
  std::vector<ProbedBody>& bodies;  ///< receives the scene's bodies
};

/// The implementation of a Scene. Owned by the Scene, its queries and its probes.
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
  /// Returns the reason for the choice of backend.
  std::string backend_reason() const { return is_closed_ ? "the scene is gone" : detector_->reason(); }
  /// Returns the device for detections on CUDA.
  int cuda_device() { return detector_->position_reader().device(); }
  const SceneStore& store() const { return *store_; }

  /// Starts a detection, after the running one has ended. If it has work to do, it runs until finish(); else it is
  /// finished.
  PendingDetection start(const DetectionRequest& request);
  /// Waits for the running detection, which start() returned for the same user. Returns it with its problem, if any.
  PendingDetection finish(const DetectionRequest& request, PendingDetection detection) noexcept;
  bool is_running(const SceneUser& user) const { return running_ == &user; }
  /// Makes the running detection's user, if any, finish it.
  void finish_running() noexcept;
  /// Finishes a running detection before the scene or a query changes, if the detection may have to be repeated with
  /// the unchanged state.
  void finish_predicted() noexcept;
  /// Drops detections that the caller has not waited for.
  void drop_detections() noexcept;
  /// Ends the running detection and refuses further ones.
  void close() noexcept;
  bool is_closed() const { return is_closed_; }
  /// Throws the errors, from any rank, of a detection that has ended.
  void conclude(PendingDetection& detection);
  /// Returns all ranks' contacts, in order.
  std::vector<Contact> gather(Span<const Contact> contacts);

  /// Answers a probe's questions, after the running detection has ended.
  void answer(const ProbeRequest& request, const Questions& ask);
  /// Calls f with the scene that the last answer() was about, with all its positions on the host.
  void answer_on_host(const std::function<void(const SceneStore&)>& f);
  void enter(SceneUser& user) { users_.push_back(&user); }
  void leave(const SceneUser& user) { std::erase(users_, &user); }

 private:
  Body& find(BodyId id);
  void validate_rank(BodyId id, const BodyDesc& desc) const;
  void meet_ranks(const QueryOptions& options, Pairs pairs);
  void start_detector(const DetectionRequest& request, PendingDetection& detection);
  std::unique_ptr<SelectedDetector> detector_for(const SceneOptions& options, DetectorFactories factories);
  void use(std::unique_ptr<SelectedDetector> detector);
  void finish_detector(const DetectionRequest& request, PendingDetection& detection, Statistics& found);
  template <class F>
  static auto reading(const F& f);
  void apply_changes(const NeededPositions& by_next, bool may_predict, bool lists_neighbours);
  bool judge_predicted();
  bool may_predict(const DetectionRequest& request) const;
  void prepare(const DetectionRequest& request, PendingDetection& detection, bool may_predict);
  ProbedScene probed_scene(const ProbeRequest& request);
  PairFilter pair_filter(const DetectionRequest& request) const;
  void warn_of_missing_positions(const QueryOptions& options);
  void require_rest_positions() const;
  NeededPositions needed_positions() const;
  SceneSize count_elements(Statistics& statistics) const;
  void warn_of_strays() const;
  void log(LogLevel level, std::string_view message) const;
  template <class MemoryProblem, class F>
  void guarded_in_memory(Statistics& statistics, const MemoryProblem& memory_problem, const F& f);
  std::string preparation_problem() const;
  std::string detection_problem() const;
  std::string answer_problem() const;
  std::string where() const;
  const char* or_raise() const { return options_.memory_limit > 0 ? ", or raise the limit" : ""; }

  SceneOptions options_;
  LogCallback log_;
  parallel::Arena arena_;  ///< a separate one, so that waiting threads work on nothing but this scene
  std::optional<SceneStore> store_{std::in_place};  ///< replaced when the scene is closed
  std::unique_ptr<RankExchange> ranks_;             ///< null where there is only one rank
  std::unique_ptr<SelectedDetector> detector_;
  std::vector<SceneUser*> users_;
  SceneUser* running_ = nullptr;  ///< user of the running detection
  bool is_closed_ = false;
  bool was_given_step_end_ = false;  ///< some body had positions at both ends of a step
  bool has_warned_of_no_positions_ = false;
  bool has_warned_of_no_end_ = false;
};

}  // namespace softcd::detail
