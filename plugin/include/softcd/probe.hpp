#pragma once

#include <functional>
#include <memory>

#include "softcd/core/spatial_query.hpp"
#include "softcd/export.hpp"
#include "softcd/query.hpp"
#include "softcd/scene.hpp"
#include "softcd/version.hpp"

namespace softcd {

namespace detail {
class ProbeCore;
}

inline namespace SOFTCD_VERSION_NAMESPACE {

/// What a probe is asked about.
struct ProbeOptions {
  /// Which end of the step is asked about.
  StepEnd step_end = StepEnd::t1;
};

/// Whether all members are equal.
SOFTCD_EXPORT bool operator==(const ProbeOptions& a, const ProbeOptions& b);
inline bool operator!=(const ProbeOptions& a, const ProbeOptions& b) {
  return !(a == b);
}  ///< see ==

/// False leaves the body out of the questions that are asked. Called on the thread that asks, in ascending order of
/// ids, for every body that has positions.
using BodyFilter = std::function<bool(BodyId body)>;

/// Asks what of a scene's bodies is at a place, in batches: questions in, as many answers out, in their order.
/// Kinematic bodies answer too; groups, masks and margins do not count. Bodies whose positions were never set are left
/// out, and so is a triangle with a vertex that is not finite, with a warning as by Query.
///
/// Every call reads positions that were set, waits for a detection that runs, and throws Error when the scene is gone,
/// OutOfMemory when memory runs out for the hierarchy of triangles that answers are found in, or for the answers. The
/// hierarchy is built when something is asked for the first time after positions, topology or bodies have changed.
/// Answers stay valid until the probe's next call, and until it is destroyed or the scene's options are set.
///
/// Answers are computed in double from the positions as the scene has them (see Positions), rays and points in full.
/// The same input gives the same bytes, whatever the number of threads or backend.
class SOFTCD_EXPORT Probe {
 public:
  /// Throws InvalidInput when an option is out of range.
  explicit Probe(Scene& scene, const ProbeOptions& options = {});
  ~Probe();
  Probe(Probe&&) noexcept;
  Probe& operator=(Probe&&) noexcept;

  /// For each ray what it meets first, of several triangles at the same t that of the lowest body and index. No ray
  /// passes between triangles that share an edge or a vertex (Woop, Benthin and Wald 2013); through these it may be
  /// said to meet any of their triangles. A triangle that the ray lies in the plane of is not met. Which triangles a
  /// ray meets is decided exactly, for the positions as the scene has them and the ray's origin relative to the
  /// scene's.
  Span<const RayHit> first_hits(Span<const Ray> rays);
  /// The same for one ray.
  RayHit first_hit(const Ray& ray);
  /// For each ray all triangles that it meets, in the order of t, then of bodies and indices.
  AnswerLists<RayHit> all_hits(Span<const Ray> rays);

  /// For each point the nearest of all triangles' points. Of triangles that are equally near, as computed, that of the
  /// lowest body and index.
  Span<const ClosestPoint> closest_points(Span<const ProbePoint> points);
  /// The same for one point.
  ClosestPoint closest_point(const ProbePoint& point);

  /// For each sphere all triangles that have a point in common with it, borders included, in the order of
  /// bodies and indices; what only touches by as much as doubles are rounded may be there or not.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeSphere> spheres);
  /// The same for capsules.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeCapsule> capsules);
  /// The same for boxes.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeBox> boxes);
  /// The same for boxes that are turned.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeOrientedBox> boxes);
  /// The same for convex hulls, told unless a plane parts them; for slivers, triangles or hulls, one that is told may
  /// be apart by somewhat more than rounding. Throws InvalidInput where all together have 2^31 points or more.
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeHull> hulls);

  /// For each pair of bodies the nearest points of a triangle of a and a triangle of b, which are different bodies:
  /// none where a is b. Of triangles that are equally near, as computed, those of the lowest body and index of a, then
  /// of b. This and the next two throw InvalidInput naming pair and body where one is not in the scene. They take time
  /// for each triangle of a: the smaller body goes first.
  Span<const BodyDistance> distances(Span<const ProbeBodies> pairs);
  /// The same for one pair.
  BodyDistance distance(const ProbeBodies& pair);

  /// For each pair of bodies all triangles of a and b that intersect: within a body where a is b, and of bodies with
  /// each other and with themselves where both are BodyId(). Each two once, the lower one first where a is b; in the
  /// order of bodies and indices of the first, then of the second.
  AnswerLists<TriangleIntersection> intersections(Span<const ProbeBodies> pairs);
  /// The same for one pair, or the whole scene.
  Span<const TriangleIntersection> intersections(const ProbeBodies& pair = {});
  /// Whether there is one, of the whole scene unless told otherwise. Stops at the first that is found.
  bool has_intersections(const ProbeBodies& pair = {});

  /// For each change of a mesh that might be made what its new triangles would intersect, as intersections() decides:
  /// all triangles that would stay, of all bodies, and each other; none where the mesh would be as free of
  /// intersections as it is. Changes are judged one by one, with the scene as it is. In the order of the added
  /// triangles, then of the others' bodies and indices, those of the same change last. New vertices are where the scene
  /// would have them, see Positions; a triangle with a vertex of the body that is not finite is left out. Throws
  /// InvalidInput naming the change, and what of it is out of range, or not finite; when the body has no positions.
  /// Each two triangles that a change would add are compared: thousands are better asked about by another scene.
  AnswerLists<ChangeIntersection> intersections_after(Span<const ProbeChange> changes);
  /// The same for one change.
  Span<const ChangeIntersection> intersections_after(const ProbeChange& change);

  /// Throws as the constructor does, and Error when the scene is gone.
  void set_options(const ProbeOptions& options);
  /// What was set last.
  const ProbeOptions& options() const;
  /// Asked by every call from the next one on; none leaves nobody out. It must not call the scene or its queries and
  /// probes.
  void set_body_filter(BodyFilter filter);

 private:
  detail::ProbeCore& core() const;

  std::unique_ptr<detail::ProbeCore> core_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
