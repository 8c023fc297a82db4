#include "softcd/probe.hpp"

#include <utility>

#include "probe_core.hpp"
#include "softcd/fields/options.hpp"

bool softcd::operator==(const ProbeOptions& a, const ProbeOptions& b) {
  return has_equal_fields(a, b);
}

namespace softcd {

Probe::Probe(Scene& scene, const ProbeOptions& options)
    : core_(guarded([] { return detail::kNoMemoryAtAll; },
                    [&] { return std::make_unique<detail::ProbeCore>(scene.shared_core(), options); })) {}
Probe::Probe(Probe&&) noexcept = default;
Probe::~Probe() = default;
Probe& Probe::operator=(Probe&&) noexcept = default;

detail::ProbeCore& Probe::core() const {
  if (core_ == nullptr) {
    throw Error("this Probe was moved from; assign one to it, or use the one that it was moved to.");
  }
  return *core_;
}

Span<const RayHit> Probe::first_hits(Span<const Ray> rays) {
  return core().first_hits(rays);
}
RayHit Probe::first_hit(const Ray& ray) {
  return core().first_hits({&ray, 1})[0];
}
AnswerLists<RayHit> Probe::all_hits(Span<const Ray> rays) {
  return core().all_hits(rays);
}
Span<const ClosestPoint> Probe::closest_points(Span<const ProbePoint> points) {
  return core().closest_points(points);
}
ClosestPoint Probe::closest_point(const ProbePoint& point) {
  return core().closest_points({&point, 1})[0];
}
AnswerLists<TriangleOverlap> Probe::overlaps(Span<const ProbeSphere> spheres) {
  return core().overlaps(spheres);
}
AnswerLists<TriangleOverlap> Probe::overlaps(Span<const ProbeCapsule> capsules) {
  return core().overlaps(capsules);
}
AnswerLists<TriangleOverlap> Probe::overlaps(Span<const ProbeBox> boxes) {
  return core().overlaps(boxes);
}
AnswerLists<TriangleOverlap> Probe::overlaps(Span<const ProbeOrientedBox> boxes) {
  return core().overlaps(boxes);
}
AnswerLists<TriangleOverlap> Probe::overlaps(Span<const ProbeHull> hulls) {
  return core().overlaps(hulls);
}
Span<const BodyDistance> Probe::distances(Span<const ProbeBodies> pairs) {
  return core().distances(pairs);
}
BodyDistance Probe::distance(const ProbeBodies& pair) {
  return core().distances({&pair, 1})[0];
}
AnswerLists<TriangleIntersection> Probe::intersections(Span<const ProbeBodies> pairs) {
  return core().intersections(pairs);
}
Span<const TriangleIntersection> Probe::intersections(const ProbeBodies& pair) {
  return core().intersections({&pair, 1}).all();
}
bool Probe::has_intersections(const ProbeBodies& pair) {
  return core().has_intersections(pair);
}
IntersectionRegions Probe::intersection_regions(const ProbeBodies& pair) {
  return core().intersection_regions(pair);
}
AnswerLists<ChangeIntersection> Probe::intersections_after(Span<const ProbeChange> changes) {
  return core().intersections_after(changes);
}
Span<const ChangeIntersection> Probe::intersections_after(const ProbeChange& change) {
  return core().intersections_after({&change, 1}).all();
}
void Probe::set_options(const ProbeOptions& options) {
  core().set_options(options);
}
const ProbeOptions& Probe::options() const {
  return core().options();
}
void Probe::set_body_filter(BodyFilter filter) {
  core().set_body_filter(std::move(filter));
}

}  // namespace softcd
