#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>

#include "body.hpp"
#include "detection_settings.hpp"
#include "explain.hpp"
#include "pair_selection.hpp"
#include "scene_snapshot.hpp"
#include "selected_detector.hpp"
#include "softcd/softcd.hpp"

namespace softcd {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMostElements = 1ULL << 31;  ///< triangles, vertices or edges in one pipeline
constexpr float kSmallestLambda = 0.1F;
constexpr float kLargestLambda = 100.0F;

void validate_options(const PipelineOptions& options) {
  if (options.lambda != 0.0F && !(options.lambda >= kSmallestLambda && options.lambda <= kLargestLambda)) {
    throw InvalidInput(
        fmt::format("lambda is {}, but a cell size is {} to {} mean radii; use 0 for the measured optimum.",
                    options.lambda, kSmallestLambda, kLargestLambda));
  }
  if (!(options.motion_margin >= 0.0F && std::isfinite(options.motion_margin))) {
    throw InvalidInput(
        fmt::format("motion_margin is {}, but it must be finite and at least 0.", options.motion_margin));
  }
}

void validate_settings(BodyId id, const BodySettings& settings) {
  if (!(settings.margin >= 0.0F && std::isfinite(settings.margin))) {
    throw InvalidInput(fmt::format("body {}: its margin is {}, but a margin must be finite and at least 0.", id.value,
                                   settings.margin));
  }
}

void validate_mesh(BodyId id, const BodyDesc& desc) {
  for (std::size_t t = 0; t < desc.triangles.size(); ++t) {
    for (const std::uint32_t v : desc.triangles[t].v) {
      if (v < desc.vertex_count) continue;
      throw InvalidInput(
          fmt::format("body {}: triangle {} has vertex index {}, but the body has {} vertices; indices count from 0.",
                      id.value, t, v, desc.vertex_count));
    }
  }
  if (desc.triangles.size() >= kMostElements || desc.vertex_count >= kMostElements) {
    throw InvalidInput(
        fmt::format("body {}: {} triangles and {} vertices are more than 2^31; split the scene over several pipelines.",
                    id.value, desc.triangles.size(), desc.vertex_count));
  }
  validate_settings(id, desc.settings);
}

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

class CollisionPipeline::Implementation {
 public:
  explicit Implementation(PipelineOptions options) : options_(std::move(options)) {
    validate_options(options_);
    detector_ = select_detector(options_);
  }

  BodyId add_body(const BodyDesc& desc) {
    const BodyId id{next_id_};
    validate_mesh(id, desc);
    bodies_.push_back(make_body(id, desc));
    ++next_id_;
    topology_changed_ = true;
    return id;
  }

  void update_body(BodyId id, const BodyDesc& desc) {
    Body& body = find(id);
    validate_mesh(id, desc);
    body = make_body(id, desc);
    topology_changed_ = true;
  }

  void set_settings(BodyId id, const BodySettings& settings) {
    Body& body = find(id);
    validate_settings(id, settings);
    body.settings = settings;
  }

  void remove_body(BodyId id) {
    const Body& body = find(id);
    bodies_.erase(bodies_.begin() + (&body - bodies_.data()));
    topology_changed_ = true;
  }

  void set_positions(BodyId id, Positions x_t0, Positions x_t1) {
    Body& body = find(id);
    check_positions(body, x_t0, "t0");
    check_positions(body, x_t1, "t1");
    if (x_t0.is_double() != x_t1.is_double()) {
      throw InvalidInput(fmt::format(
          "body {}: its positions at t0 and t1 are of different types; give both as float or both as double.",
          id.value));
    }
    body.x_t0 = x_t0;
    body.x_t1 = x_t1;
    body.moves = x_t0.data() != x_t1.data();
    body.offset = {0, 0, 0};
    body.rounding = 0;
    body.has_positions = true;
  }

  void set_options(const PipelineOptions& options) {
    validate_options(options);
    finish_pending();
    if (options.backend != options_.backend || options.cuda_stream != options_.cuda_stream) {
      detector_ = select_detector(options);
      topology_changed_ = true;
    }
    options_ = options;
    detector_->set_log(options_.log);
  }

  const PipelineOptions& options() const { return options_; }
  Backend backend() const { return detector_->backend(); }
  const Statistics& statistics() const { return statistics_; }
  std::vector<StageReport> explain() const {
    return explain_stages(options_, decisions_, detector_->reason(), statistics_);
  }

  void detect_async() {
    finish_pending();
    const Clock::time_point begin = Clock::now();
    const bool continuous = options_.detection == Detection::ccd;

    const std::vector<BodySurvey> surveys = survey_bodies(bodies_, continuous, measures_moves(options_));
    leave_out_strays(surveys);
    if (list_neighbours(bodies_)) topology_changed_ = true;
    start_statistics();
    const Vec3d origin = scene_origin(surveys);
    const bool moves = some_body_moves(surveys);
    guard_memory([&] {
      if (std::exchange(topology_changed_, false)) {
        scene_ = concatenate(bodies_);
        detector_->set_topology(scene_.topology());
      }
      write_positions(bodies_, origin, moves || measures_moves(options_), detector_->position_arrays());
    });
    pairs_ = select_pairs(bodies_, surveys, origin, margin_growth(options_), options_.pair_filter);
    const DetectionSettings settings = detection_settings(options_, pairs_, moves);
    decisions_ = {bodies_.size(),         pairs_.pair_count, pairs_.self_count,
                  pairs_.vertex_triangle, pairs_.edge_edge,  moves};
    if (pairs_.pair_count + pairs_.self_count > 0) {
      guard_memory([&] { detector_->start(pairs_.view(), settings); });
      is_running_ = true;
    }
    is_pending_ = true;
    preparation_ms_ = milliseconds_since(begin);
  }

  Span<const Contact> wait() {
    if (!is_pending_) throw Error("wait() was called, but no detection was started; call detect_async() first.");
    is_pending_ = false;
    Span<const Contact> contacts;
    if (std::exchange(is_running_, false)) guard_memory([&] { contacts = detector_->finish(statistics_); });
    statistics_.ms.transfer += preparation_ms_;
    statistics_.ms.total += preparation_ms_;
    return contacts;
  }

 private:
  static Body make_body(BodyId id, const BodyDesc& desc) {
    Body body;
    body.id = id;
    body.topology = build_topology(desc.triangles, desc.vertex_count);
    body.settings = desc.settings;
    body.ownership = body.topology.ownership;
    return body;
  }

  Body& find(BodyId id) {
    finish_pending();
    const auto found = std::lower_bound(bodies_.begin(), bodies_.end(), id,
                                        [](const Body& body, BodyId wanted) { return body.id < wanted; });
    if (found == bodies_.end() || found->id != id) {
      throw InvalidInput(fmt::format("body {} is not in the pipeline; it was removed, or never added.", id.value));
    }
    return *found;
  }

  static void check_positions(const Body& body, const Positions& positions, const char* when) {
    const std::size_t size = 3 * (positions.is_double() ? sizeof(double) : sizeof(float));
    if (positions.count() != body.topology.vertex_count) {
      throw InvalidInput(fmt::format("body {}: {} positions were given for {}, but the body has {} vertices.",
                                     body.id.value, positions.count(), when, body.topology.vertex_count));
    }
    if (positions.count() > 0 && positions.data() == nullptr) {
      throw InvalidInput(fmt::format("body {}: the pointer to its positions for {} is null.", body.id.value, when));
    }
    if (positions.count() > 1 && positions.stride() < size) {
      throw InvalidInput(
          fmt::format("body {}: the stride of its positions for {} is {} bytes, but a position is {} bytes long.",
                      body.id.value, when, positions.stride(), size));
    }
  }

  /// Triangles with a stray vertex own nothing and take no part; their other vertices and edges pass to neighbours.
  void leave_out_strays(const std::vector<BodySurvey>& surveys) {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      Body& body = bodies_[b];
      if (surveys[b].stray_vertices == body.stray_vertices) continue;
      body.stray_vertices = surveys[b].stray_vertices;
      topology_changed_ = true;
      std::vector<std::uint8_t> left_out(body.topology.triangles.size(), 0);
      body.left_out_triangles = 0;
      for (std::size_t t = 0; t < left_out.size(); ++t) {
        const auto& v = body.topology.triangles[t].v;
        left_out[t] = std::any_of(v, v + 3, [&](std::uint32_t i) {
          return std::binary_search(body.stray_vertices.begin(), body.stray_vertices.end(), i);
        });
        body.left_out_triangles += left_out[t];
      }
      body.neighbours.reset();
      body.ownership = assign_ownership(body.topology, left_out);
      for (std::size_t t = 0; t < left_out.size(); ++t) {
        if (left_out[t] != 0) body.ownership[t] = static_cast<Ownership>(kLeftOut);
      }
      if (body.stray_vertices.empty()) continue;
      log(LogLevel::warning,
          fmt::format("body {}: vertex {} is not finite or beyond 1e37 ({} such vertices); its {} triangles are left "
                      "out until it is",
                      body.id.value, body.stray_vertices.front(), body.stray_vertices.size(), body.left_out_triangles));
    }
  }

  void start_statistics() {
    statistics_ = {};
    statistics_.backend = detector_->backend();
    statistics_.bodies = bodies_.size();
    for (const Body& body : bodies_) {
      statistics_.triangles += body.topology.triangles.size();
      statistics_.vertices += body.topology.vertex_count;
      statistics_.edges += body.topology.edges.size();
      statistics_.left_out_triangles += body.left_out_triangles;
    }
    if (std::max({statistics_.triangles, statistics_.vertices, statistics_.edges}) >= kMostElements) {
      throw InvalidInput(fmt::format(
          "{} triangles, {} vertices and {} edges in one pipeline are more than 2^31; split the scene over several.",
          statistics_.triangles, statistics_.vertices, statistics_.edges));
    }
  }

  template <class F>
  void guard_memory(const F& f) {
    try {
      f();
    } catch (const std::bad_alloc&) {
      topology_changed_ = true;
      is_running_ = is_pending_ = false;
      throw OutOfMemory(fmt::format(
          "memory ran out while detecting contacts of {} triangles{}: too many triangles lie within their margins of "
          "each other. Reduce the margins, or detect fewer bodies at a time{}.",
          statistics_.triangles,
          options_.memory_limit > 0 ? fmt::format(" with a memory_limit of {} bytes", options_.memory_limit) : "",
          options_.memory_limit > 0 ? ", or raise the limit" : ""));
    }
  }

  void finish_pending() {
    if (is_pending_) wait();
  }

  void log(LogLevel level, const std::string& message) const {
    if (options_.log) options_.log(level, message);
  }

  PipelineOptions options_;
  std::unique_ptr<SelectedDetector> detector_;
  std::vector<Body> bodies_;  ///< ascending ids
  std::uint32_t next_id_ = 0;
  bool topology_changed_ = true;
  SceneArrays scene_;
  PairSelection pairs_;
  Decisions decisions_;
  Statistics statistics_;
  double preparation_ms_ = 0;
  bool is_pending_ = false;  ///< detect_async was called, wait was not
  bool is_running_ = false;  ///< the detector has work
};

CollisionPipeline::CollisionPipeline(PipelineOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(options))) {}
CollisionPipeline::~CollisionPipeline() = default;
CollisionPipeline::CollisionPipeline(CollisionPipeline&&) noexcept = default;
CollisionPipeline& CollisionPipeline::operator=(CollisionPipeline&&) noexcept = default;

BodyId CollisionPipeline::add_body(const BodyDesc& desc) {
  return implementation_->add_body(desc);
}
void CollisionPipeline::update_body(BodyId body, const BodyDesc& desc) {
  implementation_->update_body(body, desc);
}
void CollisionPipeline::set_settings(BodyId body, const BodySettings& settings) {
  implementation_->set_settings(body, settings);
}
void CollisionPipeline::remove_body(BodyId body) {
  implementation_->remove_body(body);
}
void CollisionPipeline::set_positions(BodyId body, Positions x) {
  implementation_->set_positions(body, x, x);
}
void CollisionPipeline::set_positions(BodyId body, Positions x_t0, Positions x_t1) {
  implementation_->set_positions(body, x_t0, x_t1);
}
void CollisionPipeline::set_options(const PipelineOptions& options) {
  implementation_->set_options(options);
}
const PipelineOptions& CollisionPipeline::options() const {
  return implementation_->options();
}
Span<const Contact> CollisionPipeline::detect() {
  implementation_->detect_async();
  return implementation_->wait();
}
void CollisionPipeline::detect_async() {
  implementation_->detect_async();
}
Span<const Contact> CollisionPipeline::wait() {
  return implementation_->wait();
}
Backend CollisionPipeline::backend() const {
  return implementation_->backend();
}
const Statistics& CollisionPipeline::statistics() const {
  return implementation_->statistics();
}
std::vector<StageReport> CollisionPipeline::explain() const {
  return implementation_->explain();
}

}  // namespace softcd
