#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/orientation.hpp"
#include "softcd/mesh/features.hpp"

/// Tests whether features have a point in common, borders included. The result is as exact as orientation(), also for
/// coplanar features and degenerate triangles and segments.
namespace softcd {
namespace detail {

/// Returns the point with one coordinate replaced. With the value 0 it is the point's image along the axis; with
/// another, a point in front of the image.
template <class T>
SOFTCD_HD inline Vec3<T> with_coordinate(Vec3<T> p, int axis, T value) {
  return {axis == 0 ? value : p.x, axis == 1 ? value : p.y, axis == 2 ? value : p.z};
}

/// Returns the direction in which the path a, b, c turns in the image along the axis; exactly 0 where the images are
/// collinear.
template <class T>
SOFTCD_HD inline int turn(Vec3<T> a, Vec3<T> b, Vec3<T> c, int axis) {
  return orientation(with_coordinate(a, axis, T(0)), with_coordinate(b, axis, T(0)), with_coordinate(c, axis, T(0)),
                     with_coordinate(c, axis, T(1)));
}

/// Returns whether the segments' extents along one axis overlap.
template <class T>
SOFTCD_HD inline bool do_extents_meet(T p, T q, T a, T b) {
  return smaller(p, q) <= larger(a, b) && smaller(a, b) <= larger(p, q);
}

/// Returns whether the images of two segments meet: their boxes do, and no segment lies beside the other's line.
template <class T>
SOFTCD_HD inline bool do_images_meet(Vec3<T> p, Vec3<T> q, Vec3<T> a, Vec3<T> b, int axis) {
  for (int other = 0; other < 3; ++other) {
    if (other != axis && !do_extents_meet(p[other], q[other], a[other], b[other])) return false;
  }
  return turn(a, b, p, axis) * turn(a, b, q, axis) <= 0 && turn(p, q, a, axis) * turn(p, q, b, axis) <= 0;
}

template <class T>
SOFTCD_HD inline bool is_image_inside(Vec3<T> p, const Vec3<T> (&t)[3], int axis) {
  const int side = turn(t[0], t[1], p, axis);
  return side != 0 && turn(t[1], t[2], p, axis) == side && turn(t[2], t[0], p, axis) == side;
}

/// Returns whether a segment and a triangle in one plane meet. Features that meet have images that meet. In at least
/// one of the three images, different points of the plane stay different; for collinear points, those of the line do.
template <class T>
SOFTCD_HD_LONG inline bool do_meet_in_plane(Vec3<T> p, Vec3<T> q, const Vec3<T> (&t)[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool do_meet = do_images_meet(p, q, t[0], t[1], axis) || do_images_meet(p, q, t[1], t[2], axis) ||
                         do_images_meet(p, q, t[2], t[0], axis) || is_image_inside(p, t, axis);
    if (!do_meet) return false;
  }
  return true;
}

}  // namespace detail

/// Returns whether the segment pq meets the triangle. `p_side` and `q_side` are orientation(t, p) and orientation(t,
/// q): the sides of the plane that p and q lie on.
template <class T>
SOFTCD_HD_LONG inline bool do_meet(Vec3<T> p, Vec3<T> q, int p_side, int q_side, const Vec3<T> (&t)[3]) {
  if (p_side * q_side > 0) return false;
  const int first = orientation(p, q, t[0], t[1]);
  const int second = orientation(p, q, t[1], t[2]);
  if (first * second < 0) return false;
  const int third = orientation(p, q, t[2], t[0]);
  if (first * third < 0 || second * third < 0) return false;
  if (p_side != 0 || q_side != 0) return true;
  // All in one plane, unless the triangle has no area.
  return first == 0 && second == 0 && third == 0 && detail::do_meet_in_plane(p, q, t);
}

/// Corners that two triangles of one mesh share. Bit i of `of_a` says that corner i of a is a vertex of b; `of_b` is
/// the reverse.
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

/// The sides of t's plane on which the corners of x lie; 0 for corners that t shares.
struct CornerSides {
  int side[3];
  bool
      are_on_one;  ///< t does not share all corners, and those that it does not lie on one side of the plane, not in it

  template <class T>
  SOFTCD_HD CornerSides(const Vec3<T> (&x)[3], std::uint32_t shared, const Vec3<T> (&t)[3]) {
    bool are_above = true;
    bool are_below = true;
    for (int i = 0; i < 3; ++i) {
      const bool is_shared = ((shared >> i) & 1U) != 0U;
      side[i] = is_shared ? 0 : orientation(t[0], t[1], t[2], x[i]);
      are_above &= is_shared || side[i] > 0;
      are_below &= is_shared || side[i] < 0;
    }
    are_on_one = are_above != are_below;
  }
  /// Returns whether the side from corner i to the next one has a point outside of the plane.
  SOFTCD_HD bool crosses(int i) const { return side[i] != 0 || side[i == 2 ? 0 : i + 1] != 0; }
};

/// Returns the first side of x, from a corner to the next, that meets the triangle t and has no shared corner; 3 where
/// there is none.
template <class T>
SOFTCD_HD inline int first_side_through(const Vec3<T> (&x)[3], std::uint32_t shared, const CornerSides& sides,
                                        const Vec3<T> (&t)[3]) {
  for (int i = 0; i < 3; ++i) {
    const int next = i == 2 ? 0 : i + 1;
    if ((((shared >> i) | (shared >> next)) & 1U) != 0U) continue;
    if (do_meet(x[i], x[next], sides.side[i], sides.side[next], t)) return i;
  }
  return 3;
}

/// Returns whether a side of one triangle meets the other triangle and has no shared corner.
/// - Triangles without a common vertex intersect wherever they have a point in common.
/// - Triangles with one common vertex intersect where they also meet elsewhere.
/// - Triangles with two common vertices never intersect.
template <class T>
SOFTCD_HD inline bool do_intersect(const Vec3<T> (&a)[3], const Vec3<T> (&b)[3], const SharedCorners& shared = {}) {
  const CornerSides sides_of_a(a, shared.of_a, b);
  if (sides_of_a.are_on_one) return false;
  const CornerSides sides_of_b(b, shared.of_b, a);
  if (sides_of_b.are_on_one) return false;
  return first_side_through(a, shared.of_a, sides_of_a, b) < 3 || first_side_through(b, shared.of_b, sides_of_b, a) < 3;
}

}  // namespace softcd
