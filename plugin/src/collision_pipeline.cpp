#include "softcd/collision_pipeline.hpp"

#include <optional>
#include <utility>

#include "guarded.hpp"
#include "scene_core.hpp"
#include "validation.hpp"

namespace softcd {

class CollisionPipeline::Implementation {
 public:
  Implementation(const PipelineOptions& options, LogCallback log)
      : options_(options), scene_(options, std::move(log)), query_(scene_, options) {}

  Scene& scene() { return scene_; }
  Query& query() { return query_; }
  const PipelineOptions& options() const { return options_; }

  void set_options(const PipelineOptions& options) {
    validate_options(static_cast<const QueryOptions&>(options));
    scene_.set_options(options);
    query_.set_options(options);
    ticket_.reset();
    options_ = options;
  }

  void set_pair_filter(PairFilter filter) {
    if (filter) {
      filter = [between = std::move(filter)](BodyId a, BodyId b) { return a == b || between(a, b); };
    }
    query_.set_pair_filter(std::move(filter));
  }

  void detect_async() {
    ticket_.reset();
    ticket_ = query_.start();
  }

  Span<const Contact> wait() {
    if (!ticket_) {
      throw Error("wait() was called, but no detection is running; call detect_async() before each wait().");
    }
    Ticket ticket = *std::exchange(ticket_, std::nullopt);
    return ticket.wait();
  }

 private:
  PipelineOptions options_;
  Scene scene_;
  Query query_;
  std::optional<Ticket> ticket_;
};

CollisionPipeline::CollisionPipeline(const PipelineOptions& options, LogCallback log)
    : implementation_(guarded([] { return detail::kNoMemoryAtAll; },
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
  return implementation().scene().add_body(desc);
}
void CollisionPipeline::update_body(BodyId body, const BodyDesc& desc) {
  implementation().scene().update_body(body, desc);
}
void CollisionPipeline::update_body(BodyId body, const BodyDesc& desc, Span<const std::uint32_t> changed) {
  implementation().scene().update_body(body, desc, changed);
}
void CollisionPipeline::set_settings(BodyId body, const BodySettings& settings) {
  implementation().scene().set_settings(body, settings);
}
void CollisionPipeline::remove_body(BodyId body) {
  implementation().scene().remove_body(body);
}
bool CollisionPipeline::has_body(BodyId body) const {
  return implementation().scene().has_body(body);
}
void CollisionPipeline::set_positions(BodyId body, Positions x) {
  implementation().scene().set_positions(body, x);
}
void CollisionPipeline::set_positions(BodyId body, Positions x_t0, Positions x_t1) {
  implementation().scene().set_positions(body, x_t0, x_t1);
}
void CollisionPipeline::set_ignored_pairs(Span<const BodyPair> pairs) {
  implementation().scene().set_ignored_pairs(pairs);
}
void CollisionPipeline::set_vertex_filters(BodyId body, Span<const VertexFilter> filters) {
  implementation().scene().set_vertex_filters(body, filters);
}
void CollisionPipeline::set_rest_positions(BodyId body, Positions x) {
  implementation().scene().set_rest_positions(body, x);
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
  implementation().scene().set_log(std::move(log));
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
  return implementation().scene().backend();
}
const Statistics& CollisionPipeline::statistics() const {
  return implementation().query().statistics();
}
std::vector<StageReport> CollisionPipeline::explain() const {
  return implementation().query().explain();
}

}  // namespace softcd
