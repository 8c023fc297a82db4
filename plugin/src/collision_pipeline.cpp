#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "body.hpp"
#include "detection_settings.hpp"
#include "explain.hpp"
#include "guarded.hpp"
#include "pair_selection.hpp"
#include "scene_snapshot.hpp"
#include "selected_detector.hpp"
#include "softcd/softcd.hpp"
#include "validation.hpp"

namespace softcd {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kNoMemoryAtAll = "memory ran out where hardly any is needed; free memory.";

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

class CollisionPipeline::Implementation {
 public:
  Implementation(const PipelineOptions& options, LogCallback log) : options_(options), log_(std::move(log)) {
    validate_options(options_);
    detector_ = make_detector(options_);
  }

  BodyId add_body(const BodyDesc& desc) {
    const BodyId id{next_id_};
    validate_mesh(id, desc);
    guarded([&] { return topology_problem(id, desc); }, [&] { bodies_.push_back(make_body(id, desc)); });
    ++next_id_;
    topology_changed_ = true;
    return id;
  }

  void update_body(BodyId id, const BodyDesc& desc) {
    Body& body = find(id);
    validate_mesh(id, desc);
    guarded([&] { return topology_problem(id, desc); }, [&] { body = make_body(id, desc); });
    topology_changed_ = true;
  }

  void set_settings(BodyId id, const BodySettings& settings) {
    Body& body = find(id);
    validate_settings(id, settings);
    body.settings = settings;
  }

  void remove_body(BodyId id) {
    Body& body = find(id);
    body = {};
    body.id = id;
    body.is_removed = true;
    topology_changed_ = true;
    if (++removed_count_ > bodies_.size() / 2) sweep_out_removed();
  }

  void set_positions(BodyId id, const Positions& x_t0, const Positions& x_t1) {
    Body& body = find(id);
    validate_positions(id, body.topology.vertex_count, x_t0, x_t1);
    guarded([&] { return positions_problem(id, x_t1); }, [&] { body.positions.set(x_t0, x_t1); });
  }

  void set_options(const PipelineOptions& options) {
    validate_options(options);
    const bool is_elsewhere = options.backend != options_.backend || options.cuda_stream != options_.cuda_stream;
    std::unique_ptr<SelectedDetector> detector;
    if (is_elsewhere) {
      guarded([] { return kNoMemoryAtAll; }, [&] { detector = make_detector(options); });
    }
    drop_running();
    if (is_elsewhere) {
      detector_ = std::move(detector);
      topology_changed_ = true;
    }
    options_ = options;
  }

  void set_pair_filter(PairFilter filter) { pair_filter_ = std::move(filter); }
  void set_log(LogCallback log) { log_ = std::move(log); }

  const PipelineOptions& options() const { return options_; }
  Backend backend() const { return detector_->backend(); }
  const Statistics& statistics() const { return statistics_; }
  std::vector<StageReport> explain() const {
    return guarded([] { return kNoMemoryAtAll; },
                   [&] { return explain_stages(options_, decisions_, detector_->reason(), statistics_); });
  }

  void detect_async() {
    drop_running();
    Running running;
    const Clock::time_point begin = Clock::now();
    guarded_in_memory([&] { return preparation_problem(); }, [&] { running = prepare(); });
    if (running.has_work) {
      guarded_in_memory([&] { return detection_problem(); },
                        [&] { detector_->start(pairs_.view(), running.settings); });
    }
    running.statistics.backend = detector_->backend();
    running.preparation_ms = milliseconds_since(begin);
    running_ = running;
  }

  Span<const Contact> wait() {
    if (!running_)
      throw Error("wait() was called, but no detection is running; call detect_async() before each wait().");
    Running running = *std::exchange(running_, std::nullopt);
    Span<const Contact> contacts;
    if (running.has_work) {
      guarded_in_memory([&] { return detection_problem(); }, [&] { contacts = detector_->finish(running.statistics); });
    }
    running.statistics.ms.transfer += running.preparation_ms;
    running.statistics.ms.total += running.preparation_ms;
    statistics_ = running.statistics;
    decisions_ = running.decisions;
    return contacts;
  }

 private:
  /// A detection between detect_async() and wait().
  struct Running {
    Statistics statistics;
    Decisions decisions;
    DetectionSettings settings{};
    double preparation_ms = 0;
    bool has_work = false;  ///< of the detector's
  };

  std::unique_ptr<SelectedDetector> make_detector(const PipelineOptions& options) {
    return select_detector(options, [this](LogLevel level, std::string_view message) { log(level, message); });
  }

  /// guarded(), with statistics() of how much memory there was where it ran out.
  template <class MemoryProblem, class F>
  void guarded_in_memory(const MemoryProblem& memory_problem, const F& f) {
    guarded(
        [&] {
          detector_->report_memory(statistics_);
          return memory_problem();
        },
        f);
  }

  Body& find(BodyId id) {
    const auto found = std::lower_bound(bodies_.begin(), bodies_.end(), id,
                                        [](const Body& body, BodyId wanted) { return body.id < wanted; });
    if (found == bodies_.end() || found->id != id || found->is_removed) {
      throw InvalidInput(fmt::format("body {} is not in the pipeline; it was removed, or never added.", id.value));
    }
    return *found;
  }

  /// Removed bodies leave their places only all at once: one at a time would be quadratic.
  void sweep_out_removed() {
    if (std::exchange(removed_count_, 0) == 0) return;
    const auto kept_end =
        std::remove_if(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.is_removed; });
    bodies_.erase(kept_end, bodies_.end());
  }

  /// Everything that a detection needs, but for the detector's start.
  Running prepare() {
    sweep_out_removed();
    std::vector<BodySurvey> surveys =
        survey_bodies(bodies_, options_.detection == Detection::ccd, measures_moves(options_));
    leave_out_strays(surveys);
    if (lacks_neighbours(bodies_)) {
      topology_changed_ = true;
      list_neighbours(bodies_);
    }
    Running running;
    running.statistics = scene_statistics();
    const Vec3d origin = scene_origin(surveys);
    const bool moves = some_body_moves(surveys);
    detector_->set_memory_limit(options_.memory_limit);
    upload_topology();
    write_positions(bodies_, origin, moves || measures_moves(options_), detector_->position_arrays(), surveys);
    pairs_ = select_pairs(bodies_, surveys, origin, margin_growth(options_), guarded_filter());
    running.decisions = {bodies_.size(),
                         pairs_.pair_count,
                         pairs_.self_count,
                         pairs_.vertex_triangle,
                         pairs_.edge_edge,
                         moves,
                         count_bodies_without_positions()};
    running.settings = detection_settings(options_, pairs_, moves);
    running.has_work = pairs_.pair_count + pairs_.self_count > 0;
    return running;
  }

  std::uint64_t count_bodies_without_positions() const {
    return static_cast<std::uint64_t>(
        std::count_if(bodies_.begin(), bodies_.end(), [](const Body& body) { return !body.positions.are_set(); }));
  }

  void upload_topology() {
    if (!topology_changed_) return;
    scene_ = concatenate(bodies_);
    detector_->set_topology(scene_.topology());
    topology_changed_ = false;
  }

  void leave_out_strays(const std::vector<BodySurvey>& surveys) {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      Body& body = bodies_[b];
      const std::vector<std::uint32_t>& strays = surveys[b].stray_vertices;
      if (strays == body.participation.stray_vertices) continue;
      body.participation = participation_without(strays, body.topology);
      topology_changed_ = true;
      if (strays.empty()) continue;
      log(LogLevel::warning,
          fmt::format("body {}: vertex {} is not finite or beyond 1e37 ({} such vertices); its {} triangles are left "
                      "out until it is",
                      body.id.value, strays.front(), strays.size(), body.participation.left_out_triangles));
    }
  }

  Statistics scene_statistics() const {
    Statistics result;
    result.bodies = bodies_.size();
    for (const Body& body : bodies_) {
      result.triangles += body.topology.triangles.size();
      result.vertices += body.topology.vertex_count;
      result.edges += body.topology.edges.size();
      result.left_out_triangles += body.participation.left_out_triangles;
    }
    if (std::max({result.triangles, result.vertices, result.edges}) >= kMostElements) {
      throw InvalidInput(fmt::format(
          "{} triangles, {} vertices and {} edges in one pipeline are more than 2^31; split the scene over several.",
          result.triangles, result.vertices, result.edges));
    }
    return result;
  }

  /// Waits for a detection whose result, or failure, interests nobody.
  void drop_running() noexcept {
    if (!running_) return;
    const Running dropped = *std::exchange(running_, std::nullopt);
    if (!dropped.has_work) return;
    try {
      Statistics ignored;
      detector_->finish(ignored);
    } catch (...) {  // NOLINT(bugprone-empty-catch)
    }
  }

  static std::string topology_problem(BodyId id, const BodyDesc& desc) {
    return fmt::format(
        "body {}: memory ran out while the edges of its {} triangles were listed. Free memory, or give fewer "
        "triangles.",
        id.value, desc.triangles.size());
  }

  static std::string positions_problem(BodyId id, const Positions& positions) {
    return fmt::format("body {}: memory ran out for a copy of its positions, {} bytes for each end. Free memory.",
                       id.value, positions.count() * position_size(positions));
  }

  std::string preparation_problem() const {
    return fmt::format(
        "memory ran out for the meshes and positions of {} bodies {}. Free memory{}, or split the scene over several "
        "pipelines.",
        bodies_.size(), where(), options_.memory_limit > 0 ? ", or raise the limit" : "");
  }

  std::string detection_problem() const {
    return fmt::format(
        "memory ran out while detecting contacts of {} triangles {}: too many triangles lie within their margins of "
        "each other. Reduce the margins, or detect fewer bodies at a time{}.",
        scene_.triangles.size(), where(), options_.memory_limit > 0 ? ", or raise the limit" : "");
  }

  /// Whose memory it is.
  std::string where() const {
    const char* const backend = detector_->backend() == Backend::cuda ? "on the GPU" : "on the CPU";
    if (options_.memory_limit == 0) return backend;
    return fmt::format("{} with a memory_limit of {} bytes", backend, options_.memory_limit);
  }

  PairFilter guarded_filter() const {
    if (!pair_filter_) return {};
    return [this](BodyId a, BodyId b) { return call_back(pair_filter_, a, b); };
  }

  void log(LogLevel level, std::string_view message) const {
    if (log_) call_back(log_, level, message);
  }

  PipelineOptions options_;
  PairFilter pair_filter_;
  LogCallback log_;
  std::vector<Body> bodies_;       ///< ascending ids
  std::size_t removed_count_ = 0;  ///< of bodies_
  std::uint32_t next_id_ = 0;
  bool topology_changed_ = true;
  SceneArrays scene_;    ///< what the detector has of the bodies
  PairSelection pairs_;  ///< of the last detection that was started
  std::optional<Running> running_;
  Statistics statistics_;  ///< of the last detection that was waited for
  Decisions decisions_;
  std::unique_ptr<SelectedDetector> detector_;
};

CollisionPipeline::CollisionPipeline(const PipelineOptions& options, LogCallback log)
    : implementation_(guarded([] { return kNoMemoryAtAll; },
                              [&] { return std::make_unique<Implementation>(options, std::move(log)); })) {}
CollisionPipeline::~CollisionPipeline() = default;
CollisionPipeline::CollisionPipeline(CollisionPipeline&&) noexcept = default;
CollisionPipeline& CollisionPipeline::operator=(CollisionPipeline&&) noexcept = default;

CollisionPipeline::Implementation& CollisionPipeline::implementation() const {
  if (implementation_ == nullptr) {
    throw Error("this CollisionPipeline was moved from; assign one to it, or use the one that it was moved to.");
  }
  return *implementation_;
}

BodyId CollisionPipeline::add_body(const BodyDesc& desc) {
  return implementation().add_body(desc);
}
void CollisionPipeline::update_body(BodyId body, const BodyDesc& desc) {
  implementation().update_body(body, desc);
}
void CollisionPipeline::set_settings(BodyId body, const BodySettings& settings) {
  implementation().set_settings(body, settings);
}
void CollisionPipeline::remove_body(BodyId body) {
  implementation().remove_body(body);
}
void CollisionPipeline::set_positions(BodyId body, Positions x) {
  implementation().set_positions(body, x, x);
}
void CollisionPipeline::set_positions(BodyId body, Positions x_t0, Positions x_t1) {
  implementation().set_positions(body, x_t0, x_t1);
}
void CollisionPipeline::set_options(const PipelineOptions& options) {
  implementation().set_options(options);
}
const PipelineOptions& CollisionPipeline::options() const {
  return implementation().options();
}
void CollisionPipeline::set_pair_filter(PairFilter filter) {
  implementation().set_pair_filter(std::move(filter));
}
void CollisionPipeline::set_log(LogCallback log) {
  implementation().set_log(std::move(log));
}
Span<const Contact> CollisionPipeline::detect() {
  implementation().detect_async();
  return implementation().wait();
}
void CollisionPipeline::detect_async() {
  implementation().detect_async();
}
Span<const Contact> CollisionPipeline::wait() {
  return implementation().wait();
}
Backend CollisionPipeline::backend() const {
  return implementation().backend();
}
const Statistics& CollisionPipeline::statistics() const {
  return implementation().statistics();
}
std::vector<StageReport> CollisionPipeline::explain() const {
  return implementation().explain();
}

}  // namespace softcd
