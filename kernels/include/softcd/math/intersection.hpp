#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/orientation.hpp"

/// Whether features have a point in common, borders included, decided exactly for all finite float32 coordinates: what
/// lies in one plane, and triangles and segments that are degenerate, too.
namespace softcd {
namespace detail {

/// The point's image where one looks along the axis, and a point in front of it.
SOFTCD_HD inline Vec3f with_coordinate(Vec3f p, int axis, float value) {
  return {axis == 0 ? value : p.x, axis == 1 ? value : p.y, axis == 2 ? value : p.z};
}

/// Which way the images turn from a over b to c; 0 exactly where they are on a line.
SOFTCD_HD inline int turn(Vec3f a, Vec3f b, Vec3f c, int axis) {
  return orientation(with_coordinate(a, axis, 0.0F), with_coordinate(b, axis, 0.0F), with_coordinate(c, axis, 0.0F),
                     with_coordinate(c, axis, 1.0F));
}

/// Along one axis, the segments' extents.
SOFTCD_HD inline bool do_extents_meet(float p, float q, float a, float b) {
  return smaller(p, q) <= larger(a, b) && smaller(a, b) <= larger(p, q);
}

/// Images of segments meet where their boxes do and none is beside the other's line.
SOFTCD_HD inline bool do_images_meet(Vec3f p, Vec3f q, Vec3f a, Vec3f b, int axis) {
  for (int other = 0; other < 3; ++other) {
    if (other != axis && !do_extents_meet(p[other], q[other], a[other], b[other])) return false;
  }
  return turn(a, b, p, axis) * turn(a, b, q, axis) <= 0 && turn(p, q, a, axis) * turn(p, q, b, axis) <= 0;
}

SOFTCD_HD inline bool is_image_inside(Vec3f p, const Vec3f (&t)[3], int axis) {
  const int side = turn(t[0], t[1], p, axis);
  return side != 0 && turn(t[1], t[2], p, axis) == side && turn(t[2], t[0], p, axis) == side;
}

/// Of a segment and a triangle that are in one plane. No image pulls apart what meets, and in at least one of the three
/// no two of the plane's points have the same image; of points on one line, no two of these.
SOFTCD_HD_LONG inline bool do_meet_in_plane(Vec3f p, Vec3f q, const Vec3f (&t)[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool do_meet = do_images_meet(p, q, t[0], t[1], axis) || do_images_meet(p, q, t[1], t[2], axis) ||
                         do_images_meet(p, q, t[2], t[0], axis) || is_image_inside(p, t, axis);
    if (!do_meet) return false;
  }
  return true;
}

}  // namespace detail

/// Whether the segment pq meets the triangle; the sides of its plane that p and q are on are orientation(t, p) and
/// orientation(t, q).
SOFTCD_HD_LONG inline bool do_meet(Vec3f p, Vec3f q, int p_side, int q_side, const Vec3f (&t)[3]) {
  if (p_side * q_side > 0) return false;
  const int first = orientation(p, q, t[0], t[1]);
  const int second = orientation(p, q, t[1], t[2]);
  if (first * second < 0) return false;
  const int third = orientation(p, q, t[2], t[0]);
  if (first * third < 0 || second * third < 0) return false;
  if (p_side != 0 || q_side != 0) return true;
  // In one plane, unless the triangle has no area.
  return first == 0 && second == 0 && third == 0 && detail::do_meet_in_plane(p, q, t);
}

/// Corners that two triangles of one mesh share: bit i of `of_a` says that corner i of a is a vertex of b, and so on.
struct SharedCorners {
  std::uint32_t of_a = 0, of_b = 0;
};

SOFTCD_HD inline SharedCorners shared_corners(const Triangle& a, const Triangle& b) {
  SharedCorners shared;
  for (std::uint32_t i = 0; i < 3; ++i) {
    if (has_vertex(b, a.v[i])) shared.of_a |= 1U << i;
    if (has_vertex(a, b.v[i])) shared.of_b |= 1U << i;
  }
  return shared;
}

/// The sides of the plane of t that the corners of x are on, 0 for those that t shares.
struct CornerSides {
  int side[3];

  SOFTCD_HD CornerSides(const Vec3f (&x)[3], std::uint32_t shared, const Vec3f (&t)[3]) {
    for (int i = 0; i < 3; ++i) side[i] = ((shared >> i) & 1U) != 0U ? 0 : orientation(t[0], t[1], t[2], x[i]);
  }
  /// Whether the side from that corner to the next has a point outside of the plane.
  SOFTCD_HD bool crosses(int i) const { return side[i] != 0 || side[i == 2 ? 0 : i + 1] != 0; }
  SOFTCD_HD bool are_on_one() const {
    return (side[0] > 0 && side[1] > 0 && side[2] > 0) || (side[0] < 0 && side[1] < 0 && side[2] < 0);
  }
};

/// The first side of x, from a corner to the next, that meets the triangle t and has none of the shared corners; 3
/// where none does.
SOFTCD_HD inline int first_side_through(const Vec3f (&x)[3], std::uint32_t shared, const CornerSides& sides,
                                        const Vec3f (&t)[3]) {
  for (int i = 0; i < 3; ++i) {
    const int next = i == 2 ? 0 : i + 1;
    if ((((shared >> i) | (shared >> next)) & 1U) != 0U) continue;
    if (do_meet(x[i], x[next], sides.side[i], sides.side[next], t)) return i;
  }
  return 3;
}

/// Whether a side of one of the triangles meets the other one and has no corner that this one shares: so triangles with
/// no vertex in common intersect wherever they have a point in common, those with one where they do so elsewhere, and
/// those with two never.
SOFTCD_HD inline bool do_intersect(const Vec3f (&a)[3], const Vec3f (&b)[3], const SharedCorners& shared = {}) {
  const CornerSides sides_of_a(a, shared.of_a, b);
  if (sides_of_a.are_on_one()) return false;
  const CornerSides sides_of_b(b, shared.of_b, a);
  if (sides_of_b.are_on_one()) return false;
  return first_side_through(a, shared.of_a, sides_of_a, b) < 3 || first_side_through(b, shared.of_b, sides_of_b, a) < 3;
}

}  // namespace softcd
