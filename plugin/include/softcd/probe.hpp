#pragma once

#include <functional>
#include <memory>

#include "softcd/core/spatial_query.hpp"
#include "softcd/export.hpp"
#include "softcd/intersection_regions.hpp"
#include "softcd/query.hpp"
#include "softcd/scene.hpp"
#include "softcd/version.hpp"

namespace softcd {

namespace detail {
class ProbeCore;
}

inline namespace SOFTCD_VERSION_NAMESPACE {

/// The options of a probe.
struct ProbeOptions {
  /// The end of the step whose positions the probe uses.
  StepEnd step_end = StepEnd::t1;
};

/// Returns whether all members are equal.
SOFTCD_EXPORT bool operator==(const ProbeOptions& a, const ProbeOptions& b);
inline bool operator!=(const ProbeOptions& a, const ProbeOptions& b) {
  return !(a == b);
}  ///< see ==

/// Decides which bodies a probe sees; false excludes the body. Called on the thread that calls the probe, in ascending
/// order of ids, for every body that has positions.
using BodyFilter = std::function<bool(BodyId body)>;

/// Answers spatial questions about a scene's bodies, in batches: one result or one list for each question, in the same
/// order.
///
/// **Bodies.** Kinematic bodies count too; groups, masks and margins do not. Bodies whose positions were never set are
/// left out. So are triangles with a vertex that is not finite. Each is reported by a warning, as by Query.
///
/// **Calls.** Every call reads positions that were set, and waits for a running detection. It throws Error when the
/// scene is gone, and OutOfMemory when memory runs out for the results or for the hierarchy of triangles. That
/// hierarchy is built by the first call after positions, topology or bodies have changed. Results stay valid until the
/// probe's next call, until it is destroyed, or until the scene's options are set.
///
/// **Precision.** Results are computed in double from the scene's positions (see Positions); rays and points keep full
/// precision. The same input gives the same bytes, whatever the number of threads or the backend.
class SOFTCD_EXPORT Probe {
 public:
  /// Makes a probe of the scene. Throws InvalidInput when an option is out of range.
  explicit Probe(Scene& scene, const ProbeOptions& options = {});
  ~Probe();
  Probe(Probe&&) noexcept;
  Probe& operator=(Probe&&) noexcept;

  /// Finds the first triangle that each ray meets. Of several triangles at the same t, it reports the one with the
  /// lowest body and index.
  ///
  /// The decision is exact, for the scene's positions and the ray's origin relative to the scene's. No ray passes
  /// between triangles that share an edge or a vertex (Woop, Benthin and Wald 2013). Through a shared edge or vertex it
  /// may report any of those triangles. A ray in the plane of a triangle does not meet it.
  Span<const RayHit> first_hits(Span<const Ray> rays);
  /// Finds the first hit of one ray.
  RayHit first_hit(const Ray& ray);
  /// Finds all triangles that each ray meets, in the order of t, then of bodies and indices.
  AnswerLists<RayHit> all_hits(Span<const Ray> rays);

  /// Finds the nearest point of all triangles for each point. Of triangles that are equally near, as computed, it
  /// reports the one with the lowest body and index.
  Span<const ClosestPoint> closest_points(Span<const ProbePoint> points);
  /// Finds the nearest point for one point.
  ClosestPoint closest_point(const ProbePoint& point);

  /// Finds all triangles that have a point in common with each sphere, borders included, in the order of bodies and
  /// indices. A triangle that touches within double rounding may be reported or not.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeSphere> spheres);
  /// Finds all triangles that overlap each capsule, as for spheres.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeCapsule> capsules);
  /// Finds all triangles that overlap each box, as for spheres.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeBox> boxes);
  /// Finds all triangles that overlap each oriented box, as for spheres.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeOrientedBox> boxes);
  /// Finds all triangles that overlap each convex hull, as for spheres: those that no plane separates from it. For
  /// sliver triangles or hulls, a reported triangle may be apart by somewhat more than rounding. Throws InvalidInput
  /// where all hulls together have 2^31 points or more.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeHull> hulls);

  /// Finds the nearest points of a triangle of a and a triangle of b for each pair of bodies; none where a is b. Of
  /// triangles that are equally near, as computed, it reports those with the lowest body and index of a, then of b.
  ///
  /// Takes time for each triangle of a, so the smaller body should be a. This and the next two functions throw
  /// InvalidInput, naming pair and body, where a body is not in the scene.
  Span<const BodyDistance> distances(Span<const ProbeBodies> pairs);
  /// Finds the nearest points of one pair.
  BodyDistance distance(const ProbeBodies& pair);

  /// Finds all intersecting triangles of each pair of bodies. Where a is b, it finds intersections within the body.
  /// If both are BodyId(), it compares all bodies with each other and with themselves.
  ///
  /// Intersections are exact for the positions as given: surfaces in double that are 1e-9 apart do not intersect. The
  /// other questions, distances() and intersections_after() included, are about positions rounded to float32, see
  /// Positions.
  ///
  /// Each intersection is reported once; where a is b, with the lower triangle first. The order is that of bodies and
  /// indices of the first triangle, then of the second.
  AnswerLists<TriangleIntersection> intersections(Span<const ProbeBodies> pairs);
  /// Finds the intersections of one pair, or of the whole scene.
  Span<const TriangleIntersection> intersections(const ProbeBodies& pair = {});
  /// Returns whether an intersection exists, by default in the whole scene. Stops at the first one.
  bool has_intersections(const ProbeBodies& pair = {});

  /// Finds the curves along which surfaces intersect, the regions of each surface that are on the wrong side, and the
  /// way out for their vertices. Also finds surfaces that are inside a closed one without a curve. `pair` is as for
  /// intersections(), and intersections are those of intersections().
  ///
  /// Curves, regions and ways out are those of the positions as given, float or double.
  ///
  /// The call costs about as much as intersections() if nothing intersects; a closed body adds a pass over the
  /// vertices. Curves and regions are found on the host; positions in a device's memory are copied there.
  IntersectionRegions intersection_regions(const ProbeBodies& pair = {});

  /// Finds, for each possible change of a mesh, the triangles that its new triangles would intersect: see
  /// TriangleIntersection. All positions are rounded to float32, as the scene rounds them (see Positions). New
  /// triangles are compared with all remaining triangles of all bodies, and with each other. An empty list means that
  /// the change adds no intersection. Each change is judged alone, with the scene as it is.
  ///
  /// Results are in the order of the added triangles, then of the other triangles' bodies and indices; triangles of the
  /// same change come last. Triangles with a vertex of the body that is not finite are left out.
  ///
  /// Each pair of triangles that a change adds is compared: for thousands of them, use another scene. Throws
  /// InvalidInput, naming the change, when an index is out of range, a coordinate is not finite, or the body has no
  /// positions.
  AnswerLists<ChangeIntersection> intersections_after(Span<const ProbeChange> changes);
  /// Finds the intersections that one change would add.
  Span<const ChangeIntersection> intersections_after(const ProbeChange& change);

  /// Sets the options. Throws the exceptions of the constructor, and Error when the scene is gone.
  void set_options(const ProbeOptions& options);
  /// Returns the options that were set last.
  const ProbeOptions& options() const;
  /// Sets the filter that every later call asks; an empty filter excludes no body. It must not call the scene or its
  /// queries and probes.
  void set_body_filter(BodyFilter filter);

 private:
  detail::ProbeCore& core() const;

  std::unique_ptr<detail::ProbeCore> core_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
