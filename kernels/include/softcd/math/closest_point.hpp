#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"

/// Closest points of a vertex and a triangle, and of two edges. Correct for every degenerate input. The squared
/// distance is a convex quadratic over the parameters, so its minimum is in the interior or on the boundary. The
/// functions evaluate the interior and every side of the boundary, and keep the smallest distance. A triangle without
/// area and two parallel edges have no interior minimum that a side does not also attain.
namespace softcd {

template <class T>
struct ClosestPoints {
  T weights[4];    ///< vertex-triangle {1, w0, w1, w2}, edge-edge {u0, u1, w0, w1}; in [0, 1], each side sums to 1
  T scale;         ///< safe_scale of the features: lengths are in units of 1 / scale
  Vec3<T> offset;  ///< point on side a minus point on side b
  T squared_distance;

  SOFTCD_HD T distance() const { return length(offset) / scale; }
  SOFTCD_HD bool are_within(T margin) const { return squared_distance <= (scale * margin) * (scale * margin); }
};

namespace detail {

/// Two features at one time, relative to one vertex of theirs; both kinds have the form
///     offset(x, y) = a - x b - y c.
/// Vertex-triangle: a = v - f0, b = f1 - f0, c = f2 - f0, over x >= 0, y >= 0, x + y <= 1.
/// Edge-edge: a = e0 - g0, b = e1 - e0, c = g1 - g0, over -1 <= x <= 0, 0 <= y <= 1.
/// The features are coplanar when a . (b x c) = 0.
template <class T>
struct RelativePair {
  Vec3<T> a, b, c;
};

template <class T>
SOFTCD_HD RelativePair<T> relative_vertex_triangle(Vec3<T> v, Vec3<T> f0, Vec3<T> f1, Vec3<T> f2) {
  return {v - f0, f1 - f0, f2 - f0};
}

template <class T>
SOFTCD_HD RelativePair<T> relative_edge_edge(Vec3<T> e0, Vec3<T> e1, Vec3<T> g0, Vec3<T> g1) {
  return {e0 - g0, e1 - e0, g1 - g0};
}

template <ContactKind kKind, class T>
SOFTCD_HD RelativePair<T> relative_pair(const Vec3<T> (&x)[4]) {
  return kKind == ContactKind::vertex_triangle ? relative_vertex_triangle(x[0], x[1], x[2], x[3])
                                               : relative_edge_edge(x[0], x[1], x[2], x[3]);
}

template <class T>
SOFTCD_HD RelativePair<T> scaled(T scale, const RelativePair<T>& pair) {
  return {scale * pair.a, scale * pair.b, scale * pair.c};
}

/// The parameters of two points, and the vector between them.
template <class T>
struct Nearest {
  T x, y;
  Vec3<T> offset;
  T squared_distance;
};

template <class T>
SOFTCD_HD Nearest<T> nearest_at(const RelativePair<T>& pair, T x, T y) {
  const Vec3<T> offset = pair.a - x * pair.b - y * pair.c;
  return {x, y, offset, squared_norm(offset)};
}

template <class T>
SOFTCD_HD Nearest<T> nearer(const Nearest<T>& p, const Nearest<T>& q) {
  return q.squared_distance < p.squared_distance ? q : p;
}

/// Returns the parameter in [0, 1] of the point of the segment from 0 to d that is nearest to p; 0 for a segment of
/// length 0.
template <class T>
SOFTCD_HD T nearest_on_segment(Vec3<T> p, Vec3<T> d) {
  const T along = dot(p, d);
  const T whole = squared_norm(d);
  return along > T(0) ? (along < whole ? along / whole : T(1)) : T(0);
}

/// Projects a into the plane of b and c. The result is not finite when there is no plane. Components parallel to b are
/// first removed from a and c. An error of y, however large for a needle, then moves the point by y times the needle's
/// width only, and x follows y along b. The usual quotients of cross products lose figures in proportion to the aspect.
template <class T>
SOFTCD_HD Nearest<T> nearest_in_plane(const RelativePair<T>& pair) {
  const T inverse = T(1) / squared_norm(pair.b);
  const T a_along = inverse * dot(pair.a, pair.b);
  const T c_along = inverse * dot(pair.c, pair.b);
  const Vec3<T> a_across = pair.a - a_along * pair.b;
  const Vec3<T> c_across = pair.c - c_along * pair.b;
  const T y = dot(a_across, c_across) / squared_norm(c_across);
  return nearest_at(pair, a_along - y * c_along, y);
}

/// Returns the nearest point on the side of the triangle along b (0), along c (1), or between their ends (2).
template <class T>
SOFTCD_HD Nearest<T> nearest_on_side(const RelativePair<T>& pair, int side) {
  if (side == 0) return nearest_at(pair, nearest_on_segment(pair.a, pair.b), T(0));
  if (side == 1) return nearest_at(pair, T(0), nearest_on_segment(pair.a, pair.c));
  // x + y = 1 holds exactly, which marks the third edge.
  const T x = T(1) - nearest_on_segment(pair.a - pair.b, pair.c - pair.b);
  return nearest_at(pair, x, T(1) - x);
}

template <class T>
SOFTCD_HD bool is_inside_triangle(const Nearest<T>& point) {
  return point.x > T(0) && point.y > T(0) && (T(1) - point.x) - point.y > T(0);
}

template <class T>
SOFTCD_HD Nearest<T> nearest_vertex_triangle(const RelativePair<T>& pair) {
  Nearest<T> best = nearest_on_side(pair, 0);
  best = nearer(best, nearest_on_side(pair, 1));
  best = nearer(best, nearest_on_side(pair, 2));
  const Nearest<T> inside = nearest_in_plane(pair);
  return is_inside_triangle(inside) ? nearer(best, inside) : best;
}

/// Returns whether the squared distance of nearest_vertex_triangle() is at most `squared_distance`. Stops at the first
/// point of the triangle that is as near. `foot` is nearest_in_plane().
template <class T>
SOFTCD_HD bool is_vertex_near_triangle(const RelativePair<T>& pair, const Nearest<T>& foot, T squared_distance) {
  if (is_inside_triangle(foot) && foot.squared_distance <= squared_distance) return true;
  for (int side = 0; side < 3; ++side) {
    if (nearest_on_side(pair, side).squared_distance <= squared_distance) return true;
  }
  return false;
}

template <class T>
SOFTCD_HD Nearest<T> nearest_edge_edge(const RelativePair<T>& pair) {
  const Vec3<T> backwards = -pair.b;
  Nearest<T> best = nearest_at(pair, T(0), nearest_on_segment(pair.a, pair.c));
  best = nearer(best, nearest_at(pair, T(-1), nearest_on_segment(pair.a + pair.b, pair.c)));
  best = nearer(best, nearest_at(pair, -nearest_on_segment(pair.a, backwards), T(0)));
  best = nearer(best, nearest_at(pair, -nearest_on_segment(pair.a - pair.c, backwards), T(1)));
  const Nearest<T> inside = nearest_in_plane(pair);
  const bool is_inside = inside.x < T(0) && inside.x > T(-1) && inside.y > T(0) && inside.y < T(1);
  return is_inside ? nearer(best, inside) : best;
}

template <ContactKind kKind, class T>
SOFTCD_HD Nearest<T> nearest(const RelativePair<T>& pair) {
  if constexpr (kKind == ContactKind::vertex_triangle) {
    return nearest_vertex_triangle(pair);
  } else {
    return nearest_edge_edge(pair);
  }
}

template <ContactKind kKind, class T>
SOFTCD_HD void write_weights(T x, T y, T (&weights)[4]) {
  if constexpr (kKind == ContactKind::vertex_triangle) {
    weights[0] = T(1);
    weights[1] = (T(1) - x) - y;
    weights[2] = x;
    weights[3] = y;
  } else {
    weights[0] = T(1) + x;
    weights[1] = T(0) - x;
    weights[2] = T(1) - y;
    weights[3] = y;
  }
}

template <class T>
SOFTCD_HD T extent(const RelativePair<T>& pair) {
  return larger(larger(max_norm(pair.a), max_norm(pair.b)), max_norm(pair.c));
}

template <ContactKind kKind, class T>
SOFTCD_HD ClosestPoints<T> closest_points(const RelativePair<T>& pair) {
  const T scale = safe_scale(extent(pair));
  const Nearest<T> result = nearest<kKind>(scale == T(1) ? pair : scaled(scale, pair));
  ClosestPoints<T> points;
  write_weights<kKind>(result.x, result.y, points.weights);
  points.scale = scale;
  points.offset = result.offset;
  points.squared_distance = result.squared_distance;
  return points;
}

}  // namespace detail

/// Returns the point of triangle f0 f1 f2 that is nearest to v. Differences of the coordinates must be finite.
template <class T>
SOFTCD_HD ClosestPoints<T> closest_points_vertex_triangle(Vec3<T> v, Vec3<T> f0, Vec3<T> f1, Vec3<T> f2) {
  return detail::closest_points<ContactKind::vertex_triangle>(detail::relative_vertex_triangle(v, f0, f1, f2));
}

/// Returns the nearest points of the segments e0 e1 (side a) and g0 g1 (side b). Differences of the coordinates must be
/// finite.
template <class T>
SOFTCD_HD ClosestPoints<T> closest_points_edge_edge(Vec3<T> e0, Vec3<T> e1, Vec3<T> g0, Vec3<T> g1) {
  return detail::closest_points<ContactKind::edge_edge>(detail::relative_edge_edge(e0, e1, g0, g1));
}

}  // namespace softcd
