#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "softcd/core/contact.hpp"
#include "softcd/core/span.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// The distance reported where a probe finds nothing.
constexpr double kInfiniteDistance = std::numeric_limits<double>::infinity();

/// The points origin + t direction, t_min <= t <= t_max, in world coordinates. The direction may have any length but 0;
/// t is in units of it. A ray hits nothing in these cases:
/// - its direction is 0;
/// - t_min <= t_max is false;
/// - a member other than t_min and t_max is not finite;
/// - its origin is further than 1e37 from the scene's origin.
struct Ray {
  Vec3d origin;                      ///< in world coordinates
  Vec3d direction;                   ///< the unit of t
  double t_min = 0;                  ///< where the ray begins
  double t_max = kInfiniteDistance;  ///< where it ends
};

/// Returns the ray from t = 0 at `from` to t = 1 at `to`.
inline Ray segment(Vec3d from, Vec3d to) {
  return {from, to - from, 0, 1};
}

/// The point at which a ray meets a triangle.
struct RayHit {
  BodyId body;                        ///< BodyId() where the ray hits nothing; weights and normal are then 0
  std::uint32_t triangle = kNoIndex;  ///< index in the body
  double t = kInfiniteDistance;       ///< the point is origin + t direction; infinite where the ray hits nothing
  float weights[3] = {0, 0, 0};       ///< the point's weights on the triangle's vertices, in [0, 1]; their sum is 1
  /// Unit vector along (x1 - x0) x (x2 - x0), whichever side the ray comes from. 0 for a triangle without area.
  Vec3f normal{0, 0, 0};

  /// Returns whether the ray meets a triangle.
  bool has_hit() const { return body != BodyId(); }
};

/// A point for which a probe finds the nearest triangle within max_distance. The probe finds nothing where a coordinate
/// or max_distance is NaN, where max_distance is negative, or where the point is further than 1e37 from the scene's
/// origin.
struct ProbePoint {
  Vec3d point;                              ///< in world coordinates
  double max_distance = kInfiniteDistance;  ///< at least 0; in the positions' unit
};

/// The nearest point of a scene's triangles.
struct ClosestPoint {
  BodyId body;  ///< BodyId() where nothing is within max_distance; position and weights are then 0
  std::uint32_t triangle = kNoIndex;    ///< index in the body
  Vec3d position{0, 0, 0};              ///< in world coordinates
  double distance = kInfiniteDistance;  ///< at least 0; infinite where nothing is within max_distance
  float weights[3] = {0, 0, 0};         ///< the point's weights on the triangle's vertices, in [0, 1]; their sum is 1
  /// The side of a closed surface: 1 where normals point to, -1 opposite, 0 on the surface. Also 0 where the body's
  /// surface is not closed, or a segment is nearest.
  ///
  /// A surface is closed when
  /// - every edge has two triangles, which pass through it in opposite directions;
  /// - the triangles of each vertex surround it once;
  /// - all vertices of triangles are finite.
  ///
  /// The sign comes from the angle-weighted normal of the nearest feature (Baerentzen and Aanaes 2005). It
  /// distinguishes inside from outside where the surface does not intersect itself.
  std::int32_t side = 0;

  /// Returns whether a triangle is within max_distance.
  bool has_point() const { return body != BodyId(); }
};

/// All points at most `radius` from the centre, in world coordinates. Empty where a member is NaN, the radius is
/// negative, or the centre is further than 1e37 from the scene's origin.
struct ProbeSphere {
  Vec3d centre;   ///< in world coordinates
  double radius;  ///< at least 0; in the positions' unit
};

/// All points at most `radius` from the segment between two points, in world coordinates; a ball where the points are
/// equal. Empty where a member is NaN, the radius is negative, or a point is further than 1e37 from the scene's origin.
struct ProbeCapsule {
  Vec3d from;     ///< one end of the segment, in world coordinates
  Vec3d to;       ///< the other end
  double radius;  ///< at least 0; in the positions' unit
};

/// All points between lo and hi, in world coordinates. Empty where a coordinate is NaN, or lo is above hi.
struct ProbeBox {
  Vec3d lo;  ///< the lowest coordinates
  Vec3d hi;  ///< the highest coordinates
};

/// All points centre + x axes[0] + y axes[1] + z axes[2] with |x| <= half.x and so on, in world coordinates. The axes
/// are unit vectors at right angles to each other, up to rounding. Empty where a member is NaN, half has a negative
/// component, or the centre is further than 1e37 from the scene's origin.
struct ProbeOrientedBox {
  Vec3d centre;  ///< in world coordinates
  Vec3d half;    ///< half of the box's extent along each axis
  /// The box's own axes.
  Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};

/// All points at most `radius` from the convex hull of some points, in world coordinates: a polyhedron, a piece of a
/// plane or a line, a ball around one point. The points may be in any order. Points inside the hull, coplanar,
/// collinear or repeated points only cost time. Empty where there is no point, a member is NaN, the radius is negative,
/// or a point is further than 1e37 from the scene's origin.
struct ProbeHull {
  Span<const Vec3d> points;  ///< in world coordinates; read during the call
  double radius = 0;         ///< at least 0; in the positions' unit
};

/// A triangle that has a point in common with a shape.
struct TriangleOverlap {
  BodyId body;             ///< the triangle's body
  std::uint32_t triangle;  ///< index in the body
};

/// A pair of bodies that a probe compares. BodyId() stands for all of the probe's bodies: {a, BodyId()} are the pairs
/// of a with each other body, {BodyId(), BodyId()} are all pairs.
struct ProbeBodies {
  BodyId a;  ///< the first body
  BodyId b;  ///< the second body
};

/// Two triangles that intersect.
/// - In different bodies, they have a point in common, borders included.
/// - In one body, a side of one triangle meets the other triangle, and that side has no vertex of the other triangle.
///
/// So triangles that share an edge never intersect. Triangles that share a vertex intersect only if they also meet
/// elsewhere. The decision is exact for the given positions, float or double, also for coplanar, touching and
/// degenerate triangles.
struct TriangleIntersection {
  BodyId body_a;             ///< the first triangle's body
  std::uint32_t triangle_a;  ///< index in body_a
  BodyId body_b;             ///< the second triangle's body, which may be the same
  std::uint32_t triangle_b;  ///< index in body_b
};

/// A possible change of one body's mesh: an edge split, collapsed or flipped, a hole filled.
struct ProbeChange {
  BodyId body;                          ///< the body whose mesh would change
  Span<const std::uint32_t> removed{};  ///< indices of the triangles that the change removes
  /// the triangles that it adds; new vertex i has the index `vertex count of the body + i`
  Span<const Triangle> added{};
  Span<const Vec3d> new_vertices{};  ///< in world coordinates; a moved vertex counts as a new one
};

/// A triangle that a change would add, and a triangle that it would intersect; see TriangleIntersection.
struct ChangeIntersection {
  std::uint32_t added;     ///< index in ProbeChange::added
  BodyId body;             ///< the other triangle's body; BodyId() where the change adds that one, too
  std::uint32_t triangle;  ///< index in that body as it is, or a higher index in ProbeChange::added
};

/// The nearest points of two bodies' triangles.
struct BodyDistance {
  BodyId body_a;  ///< BodyId() where there is nothing to compare; positions and weights are then 0
  BodyId body_b;  ///< another body
  std::uint32_t triangle_a = kNoIndex;  ///< index in body_a
  std::uint32_t triangle_b = kNoIndex;  ///< index in body_b
  Vec3d position_a{0, 0, 0};            ///< the point of triangle_a, in world coordinates
  Vec3d position_b{0, 0, 0};            ///< the point of triangle_b
  /// At least 0. Exactly 0 where the triangles intersect; infinite where there is nothing to compare.
  double distance = kInfiniteDistance;
  /// The point's weights on triangle_a's vertices, in [0, 1]; their sum is 1. The point lies on a vertex, an edge or
  /// the face; weights of vertices off that feature are exactly 0.
  float weights_a[3] = {0, 0, 0};
  float weights_b[3] = {0, 0, 0};  ///< the same for triangle_b

  /// Returns whether there were two bodies with triangles.
  bool has_points() const { return body_a != BodyId(); }
};

/// Lists of results, one for each element of a batch, in the batch's order.
template <class T>
class AnswerLists {
 public:
  /// Makes an empty batch.
  AnswerLists() = default;
  /// Makes a batch whose element i has the results begins[i] <= j < begins[i + 1].
  AnswerLists(Span<const std::uint64_t> begins, Span<const T> answers) : begins_(begins), answers_(answers) {}

  /// Returns the number of lists.
  std::size_t size() const { return begins_.empty() ? 0 : begins_.size() - 1; }
  /// Returns one list. `question` must be below size(); it is not checked.
  Span<const T> operator[](std::size_t question) const {
    const std::uint64_t begin = begins_[question];
    return {answers_.data() + begin, static_cast<std::size_t>(begins_[question + 1] - begin)};
  }
  /// Returns all results, one list behind the other.
  Span<const T> all() const { return answers_; }
  /// Returns where each list begins in all(), and at last where the last list ends. Empty for an empty batch.
  Span<const std::uint64_t> begins() const { return begins_; }

 private:
  Span<const std::uint64_t> begins_;
  Span<const T> answers_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
