#pragma once

#include <cfloat>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"

/// A test whether the triangles around a vertex are spread out: then no two of them come near each other away from what
/// they share. Like the criterion of Volino and Magnenat-Thalmann (Efficient self-collision detection on smoothly
/// discretized surface animations using geometrical shape regularity, 1994) it looks at a surface along one direction.
///
/// Seen along a direction, let the triangles turn once around the vertex, all in one sense, with all altitudes above
/// `distance`. Then features of two of them which share no vertex are further apart than `distance`:
/// - A vertex of the ring is outside of the wedges of triangles without it. The angle to the next of them is no less
///   than that of one of its own triangles. So its distance is no less than an altitude of that triangle.
/// - Edges do not cross, so that one of their ends is nearest.
/// Projections are no longer than distances.
namespace softcd {
namespace detail {

/// The least altitude, relative to the longest edge. Thinner triangles are not judged. So roundings are far smaller
/// than altitudes: a triple product has an error of at most 7 epsilon times its factors' lengths, and the direction to
/// a vertex of the ring, as seen, one of at most 0.004. Two neighbours on the ring are at least 0.015 apart.
constexpr float kLeastAltitude = 1.0F / 64.0F;
/// Makes up for all roundings, of altitudes and of distances: 2^-6 / 1000 is 130 epsilon.
constexpr float kAltitudeFactor = 1.001F;
/// The lengths for which nothing overflows, and what underflows is too small to matter.
constexpr float kShortestEdge = 0x1p-16F;
constexpr float kLongestEdge = 0x1p+28F;
constexpr float kShortestNormal = 0x1p-40F;

}  // namespace detail

/// The ring of a star at both ends of the step, or twice at t1, relative to its centre.
template <int kMost>
struct StarMotion {
  Vec3f t0[kMost + 1];
  Vec3f t1[kMost + 1];
  int triangle_count;
  bool is_closed;  ///< the last vertex is the first
};

namespace detail {

/// The coefficients, in Bernstein form, of a product of two vectors that move on straight lines.
struct QuadraticBounds {
  float b0, b1, b2;

  SOFTCD_HD float lowest() const { return smaller(smaller(b0, b1), b2); }
  SOFTCD_HD float highest() const { return larger(larger(b0, b1), b2); }
};

/// The signed area, doubled, of a triangle of the star, as seen along the unit vector n.
template <bool kSwept>
SOFTCD_HD QuadraticBounds area_along(const Vec3f& n, const Vec3f& a_t0, const Vec3f& a_t1, const Vec3f& b_t0,
                                     const Vec3f& b_t1) {
  const float at_t1 = dot(n, cross(a_t1, b_t1));
  if constexpr (!kSwept) return {at_t1, at_t1, at_t1};
  return {dot(n, cross(a_t0, b_t0)), 0.5F * dot(n, cross(a_t0, b_t1) + cross(a_t1, b_t0)), at_t1};
}

/// The dot product of a and b as seen along n.
SOFTCD_HD inline float dot_along(const Vec3f& n, const Vec3f& a, const Vec3f& b) {
  return dot(a, b) - dot(n, a) * dot(n, b);
}
template <bool kSwept>
SOFTCD_HD QuadraticBounds dots_along(const Vec3f& n, const Vec3f& a_t0, const Vec3f& a_t1, const Vec3f& b_t0,
                                     const Vec3f& b_t1) {
  const float at_t1 = dot_along(n, a_t1, b_t1);
  if constexpr (!kSwept) return {at_t1, at_t1, at_t1};
  return {dot_along(n, a_t0, b_t0), 0.5F * (dot_along(n, a_t0, b_t1) + dot_along(n, a_t1, b_t0)), at_t1};
}

}  // namespace detail

/// Returns true only if features of the star that share no vertex stay further apart than `distance` during the step.
template <bool kSwept, int kMost>
SOFTCD_HD bool is_certainly_spread(const StarMotion<kMost>& star, float distance) {
  const int last = star.triangle_count;
  const Vec3f* const t0 = star.t0;
  const Vec3f* const t1 = star.t1;
  Vec3f normal{0.0F, 0.0F, 0.0F};
  float longest = squared_norm(t1[0]);
  if constexpr (kSwept) longest = larger(longest, squared_norm(t0[0]));
  for (int i = 0; i < last; ++i) {
    normal = normal + cross(t1[i], t1[i + 1]);
    longest = larger(longest, larger(squared_norm(t1[i + 1]), squared_norm(t1[i + 1] - t1[i])));
    if constexpr (kSwept) {
      normal = normal + cross(t0[i], t0[i + 1]);
      longest = larger(longest, larger(squared_norm(t0[i + 1]), squared_norm(t0[i + 1] - t0[i])));
    }
  }
  longest = square_root(longest);
  const float length = norm(normal);
  if (!(longest >= detail::kShortestEdge && longest <= detail::kLongestEdge && length >= detail::kShortestNormal)) {
    return false;
  }
  const Vec3f n = (1.0F / length) * normal;
  // The quarter turns next to the first vertex and those opposite to it: a ring that turns once comes back from the
  // latter once, and an open one that turns by less than three quarters never.
  const Vec3f first = t1[0] - dot(n, t1[0]) * n;
  bool was_behind = false;
  int returns = 0;
  float least = FLT_MAX;
  for (int i = 0; i < last; ++i) {
    least = smaller(least, detail::area_along<kSwept>(n, t0[i], t1[i], t0[i + 1], t1[i + 1]).lowest());
    const bool is_behind = !(dot(first, t1[i + 1]) > 0.0F);
    returns += was_behind && !is_behind ? 1 : 0;
    was_behind = is_behind;
  }
  const float altitude = detail::kAltitudeFactor * larger(distance, detail::kLeastAltitude * longest);
  if (!(least > altitude * longest)) return false;
  if (star.is_closed) return returns == 1;
  const bool is_wide = detail::dots_along<kSwept>(n, t0[0], t1[0], t0[last], t1[last]).highest() <= 0.0F;
  const bool is_narrow = detail::area_along<kSwept>(n, t0[0], t1[0], t0[last], t1[last]).lowest() > 0.0F;
  return returns == 0 && (is_wide || is_narrow);
}

}  // namespace softcd
