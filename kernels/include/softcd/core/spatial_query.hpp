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

/// How far away what is not there is.
constexpr double kInfiniteDistance = std::numeric_limits<double>::infinity();

/// The points origin + t direction, t_min <= t <= t_max, in world coordinates. Of any length but 0: t counts in
/// directions. A ray hits nothing where its direction is 0, where t_min <= t_max is false, where anything but t_min and
/// t_max is not finite, and where its origin is further than 1e37 from the scene's.
struct Ray {
  Vec3d origin;                      ///< in world coordinates
  Vec3d direction;                   ///< the unit of t
  double t_min = 0;                  ///< where the ray begins
  double t_max = kInfiniteDistance;  ///< where it ends
};

/// From t = 0 to t = 1.
inline Ray segment(Vec3d from, Vec3d to) {
  return {from, to - from, 0, 1};
}

/// Where a ray meets a triangle.
struct RayHit {
  BodyId body;                        ///< BodyId() where the ray hits nothing; weights and normal are 0 then
  std::uint32_t triangle = kNoIndex;  ///< of the body
  double t = kInfiniteDistance;       ///< the point is origin + t direction; infinite where the ray hits nothing
  float weights[3] = {0, 0, 0};       ///< of the triangle's vertices there, in [0, 1]; their sum is 1
  /// Unit vector along (x1 - x0) x (x2 - x0), whichever side the ray comes from; 0 for a triangle without area.
  Vec3f normal{0, 0, 0};

  /// Whether the ray meets a triangle.
  bool has_hit() const { return body != BodyId(); }
};

/// A point in world coordinates that is asked for what is nearest to it, and at most max_distance away. There is
/// nothing where a coordinate or max_distance is NaN, where max_distance is negative, and where the point is further
/// than 1e37 from the scene's origin.
struct ProbePoint {
  Vec3d point;                              ///< in world coordinates
  double max_distance = kInfiniteDistance;  ///< at least 0; in the positions' unit
};

/// The nearest point of a scene's triangles.
struct ClosestPoint {
  BodyId body;  ///< BodyId() where there is nothing within max_distance; position and weights are 0 then
  std::uint32_t triangle = kNoIndex;    ///< of the body
  Vec3d position{0, 0, 0};              ///< in world coordinates
  double distance = kInfiniteDistance;  ///< at least 0; infinite where there is nothing within max_distance
  float weights[3] = {0, 0, 0};         ///< of the triangle's vertices there, in [0, 1]; their sum is 1
  /// Where the body's surface is closed: 1 on the side that normals point to, -1 on the other, 0 on the surface, and
  /// where a segment is nearest. Where it is not, 0. Closed: every edge has two triangles that pass through it in
  /// opposite directions, the triangles of each vertex surround it once, and all vertices of triangles are finite. By
  /// the angle-weighted normal of the nearest feature (Baerentzen and Aanaes 2005), which means inside and outside
  /// where the surface does not intersect itself.
  std::int32_t side = 0;

  /// Whether there is something within max_distance.
  bool has_point() const { return body != BodyId(); }
};

/// All points at most `radius` from the centre, in world coordinates. Nothing where anything is NaN, the radius is
/// negative, or the centre is further than 1e37 from the scene's origin.
struct ProbeSphere {
  Vec3d centre;   ///< in world coordinates
  double radius;  ///< at least 0; in the positions' unit
};

/// All points at most `radius` from the segment between two points, in world coordinates; a ball where these are equal.
/// Nothing where anything is NaN, the radius is negative, or a point is further than 1e37 from the scene's origin.
struct ProbeCapsule {
  Vec3d from;     ///< one end of the segment, in world coordinates
  Vec3d to;       ///< the other one
  double radius;  ///< at least 0; in the positions' unit
};

/// All points between lo and hi, in world coordinates; where one of them is NaN, or lo is above hi, none.
struct ProbeBox {
  Vec3d lo;  ///< its lowest coordinates
  Vec3d hi;  ///< its highest coordinates
};

/// All points centre + x axes[0] + y axes[1] + z axes[2], |x| <= half.x and so on, in world coordinates. The axes are
/// unit vectors at right angles to each other, as far as rounding lets them. Nothing where anything is NaN, half has a
/// negative component, or the centre is further than 1e37 from the scene's origin.
struct ProbeOrientedBox {
  Vec3d centre;  ///< in world coordinates
  Vec3d half;    ///< half its extent along each axis
  /// Its own, along which it extends.
  Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};

/// All points at most `radius` from the convex hull of some points, in world coordinates: a polyhedron, a piece of a
/// plane or a line, a ball around one point. In any order; what is inside, in a plane, on a line with others, or there
/// twice, changes nothing but the time, to which each point adds. Nothing where there is no point, anything is NaN, the
/// radius is negative, or a point is further than 1e37 from the scene's origin.
struct ProbeHull {
  Span<const Vec3d> points;  ///< in world coordinates; read during the call
  double radius = 0;         ///< at least 0; in the positions' unit
};

/// A triangle that has a point in common with a shape.
struct TriangleOverlap {
  BodyId body;             ///< the one that the triangle is of
  std::uint32_t triangle;  ///< of the body
};

/// Two bodies that are asked about. BodyId() stands for all that the probe asks about: {a, BodyId()} are the pairs of a
/// with each other body, {BodyId(), BodyId()} are all pairs.
struct ProbeBodies {
  BodyId a;  ///< the first
  BodyId b;  ///< the second
};

/// Two triangles that intersect: of different bodies where they have a point in common, borders included; of one body
/// where a side of one and the other triangle do that have no vertex in common. So what is joined by an edge never
/// intersects, and what is joined by a vertex only beyond that. Decided exactly for the positions as the scene has them
/// (see Positions), of what is coplanar, touches or has no area, too.
struct TriangleIntersection {
  BodyId body_a;             ///< that of the first triangle
  std::uint32_t triangle_a;  ///< of body_a
  BodyId body_b;             ///< that of the second one, which may be the same
  std::uint32_t triangle_b;  ///< of body_b
};

/// A change of one body's mesh that might be made: an edge split, collapsed or flipped, a hole filled.
struct ProbeChange {
  BodyId body;                          ///< whose mesh it is
  Span<const std::uint32_t> removed{};  ///< triangles of the body that would not be there any more
  Span<const Triangle> added{};         ///< what would come instead; `vertex count of the body + i` is new vertex i
  Span<const Vec3d> new_vertices{};     ///< in world coordinates; a vertex that would move is a new one
};

/// A triangle that a change would add, and what it would intersect; see TriangleIntersection.
struct ChangeIntersection {
  std::uint32_t added;     ///< index in ProbeChange::added
  BodyId body;             ///< what the other one is of; BodyId() where it would be added, too
  std::uint32_t triangle;  ///< of the body as it is, or a higher index in ProbeChange::added
};

/// The nearest points of two bodies' triangles.
struct BodyDistance {
  BodyId body_a;  ///< BodyId() where there is nothing to compare; positions and weights are 0 then
  BodyId body_b;  ///< another one
  std::uint32_t triangle_a = kNoIndex;  ///< of body_a
  std::uint32_t triangle_b = kNoIndex;  ///< of body_b
  Vec3d position_a{0, 0, 0};            ///< the point of triangle_a, in world coordinates
  Vec3d position_b{0, 0, 0};            ///< the point of triangle_b
  /// At least 0; exactly 0 where the triangles intersect; infinite where there is nothing to compare.
  double distance = kInfiniteDistance;
  /// Of triangle_a's vertices at the point, in [0, 1]; their sum is 1. Those of vertices that are not of the feature
  /// that it is on, a vertex or an edge, are 0 exactly.
  float weights_a[3] = {0, 0, 0};
  float weights_b[3] = {0, 0, 0};  ///< the same of triangle_b's

  /// Whether there were two bodies with triangles.
  bool has_points() const { return body_a != BodyId(); }
};

/// Lists of answers, one for each question of a batch, in the questions' order.
template <class T>
class AnswerLists {
 public:
  /// Without questions.
  AnswerLists() = default;
  /// Question i has the answers begins[i] <= j < begins[i + 1].
  AnswerLists(Span<const std::uint64_t> begins, Span<const T> answers) : begins_(begins), answers_(answers) {}

  /// Questions.
  std::size_t size() const { return begins_.empty() ? 0 : begins_.size() - 1; }
  /// The answers of one question; `question`, which is not checked, is below size().
  Span<const T> operator[](std::size_t question) const {
    const std::uint64_t begin = begins_[question];
    return {answers_.data() + begin, static_cast<std::size_t>(begins_[question + 1] - begin)};
  }
  /// All answers, those of one question behind those of the one before.
  Span<const T> all() const { return answers_; }
  /// Where each question's answers begin in all(), and where the last one's end: none where there are no questions.
  Span<const std::uint64_t> begins() const { return begins_; }

 private:
  Span<const std::uint64_t> begins_;
  Span<const T> answers_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
