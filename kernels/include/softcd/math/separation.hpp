#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/impact/motion.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// A moving set of points: their positions at both ends of the step.
template <int kCount>
struct PointMotion {
  Vec3f t0[kCount];
  Vec3f t1[kCount];
};

struct Interval {
  float lo, hi;
};

/// Returns the interval of the points begin <= i < end along x, y or z.
template <int kAxis>
SOFTCD_HD constexpr Interval interval_of(const Vec3f* points, int begin, int end) {
  Interval interval = {points[begin][kAxis], points[begin][kAxis]};
  for (int i = begin + 1; i < end; ++i) {
    interval.lo = smaller(interval.lo, points[i][kAxis]);
    interval.hi = larger(interval.hi, points[i][kAxis]);
  }
  return interval;
}

template <bool kSwept, int kAxis, int kSplit, int kCount>
SOFTCD_HD bool apart_on_axis(const PointMotion<kCount>& points, float distance) {
  const Interval a_t1 = interval_of<kAxis>(points.t1, 0, kSplit);
  const Interval b_t1 = interval_of<kAxis>(points.t1, kSplit, kCount);
  bool is_below = outward_up(a_t1.hi + distance) < b_t1.lo;
  bool is_above = outward_up(b_t1.hi + distance) < a_t1.lo;
  if constexpr (kSwept) {
    const Interval a_t0 = interval_of<kAxis>(points.t0, 0, kSplit);
    const Interval b_t0 = interval_of<kAxis>(points.t0, kSplit, kCount);
    is_below &= outward_up(a_t0.hi + distance) < b_t0.lo;
    is_above &= outward_up(b_t0.hi + distance) < a_t0.lo;
  }
  return is_below | is_above;
}

/// Returns whether the first kSplit points lie more than `distance`, a straight_distance, beyond the others along x, y
/// or z. If kSwept, at both ends of a straight-line motion and hence throughout; else at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_straight_axes(const PointMotion<kCount>& points, float distance) {
  const bool x = apart_on_axis<kSwept, 0, kSplit>(points, distance);
  const bool y = apart_on_axis<kSwept, 1, kSplit>(points, distance);
  const bool z = apart_on_axis<kSwept, 2, kSplit>(points, distance);
  return x | y | z;
}

namespace detail {

/// Bounds the roundings of certainly_apart_in_a_direction(), relative to |n| (A + B + C), and the tolerance of
/// distances. The roundings are those of the differences, of their sums, of a dot product, and of the margin's product
/// with |n|. The margin counts only up to sqrt(3) (A + B + C), as a larger one exceeds |n|.
/// docs/inside/proofs.md bounds all of them.
constexpr float kSeparationError = kDistanceError<float> + 16.0F * epsilon<float>();
/// The smallest length of a direction. A shorter one cannot separate: kSeparationError (A + B + C) is larger, because
/// safe_scale() makes one of A, B and C at least 2^-16.
constexpr float kShortestDirection = 0x1p-40F;
/// Most changes of the direction. More find more, but cost as much time as the narrow phase then saves. Of a recorded
/// continuous step of an armadillo, 4 changes reject 64 % of the features that do not touch, 8 reject 72 %, 12 76 %.
template <bool kSwept>
constexpr int kMostDirections = kSwept ? 8 : 4;

/// The differences of two features' vertices, at t1 and, if kSwept, at t0.
template <ContactKind kKind, bool kSwept>
struct Differences {
  static constexpr int kOfEnd = kKind == ContactKind::vertex_triangle ? 3 : 4;
  static constexpr int kCount = kSwept ? 2 * kOfEnd : kOfEnd;

  Vec3f at[kCount];

  SOFTCD_HD Differences(const RelativePair<float>& t0, const RelativePair<float>& t1) {
    set(t1, 0);
    if constexpr (kSwept) set(t0, kOfEnd);
  }

 private:
  SOFTCD_HD void set(const RelativePair<float>& pair, int first) {
    at[first] = pair.a;
    at[first + 1] = pair.a - pair.c;
    if constexpr (kKind == ContactKind::vertex_triangle) {
      at[first + 2] = pair.a - pair.b;
    } else {
      at[first + 2] = pair.a + pair.b;
      at[first + 3] = at[first + 2] - pair.c;
    }
  }
};

}  // namespace detail

/// Returns true only where the features stay further apart than `margin` along one direction. If kSwept, at both ends
/// of a straight-line motion and hence throughout; else at t1. The direction is that of the point next to the origin in
/// the convex hull of all differences of their vertices. A few steps approach that point (Gilbert, An iterative
/// procedure for computing the minimum of a quadratic form on a convex set, 1966).
template <ContactKind kKind, bool kSwept>
SOFTCD_HD bool certainly_apart_in_a_direction(const PointMotion<4>& points, float margin) {
  detail::RelativePair<float> t1 = detail::relative_pair<kKind>(points.t1);
  detail::RelativePair<float> t0 = kSwept ? detail::relative_pair<kKind>(points.t0) : t1;
  const float scale = safe_scale(larger(detail::extent(t0), detail::extent(t1)));
  if (scale != 1.0F) {
    t0 = detail::scaled(scale, t0);
    t1 = detail::scaled(scale, t1);
    margin *= scale;
  }
  const float size = (larger(max_norm(t0.a), max_norm(t1.a)) + larger(max_norm(t0.b), max_norm(t1.b))) +
                     larger(max_norm(t0.c), max_norm(t1.c));
  const float distance = margin + detail::kSeparationError * size;
  const detail::Differences<kKind, kSwept> differences(t0, t1);
  Vec3f n = differences.at[0];
  for (int i = 1; i < differences.kCount; ++i) n = n + differences.at[i];
  n = (1.0F / static_cast<float>(differences.kCount)) * n;
  for (int change = 0;; ++change) {
    // n is in the hull: no direction leaves more than its length.
    const float length = norm(n);
    if (!(length > larger(margin, detail::kShortestDirection))) return false;
    Vec3f lowest = differences.at[0];
    float least = dot(n, lowest);
    for (int i = 1; i < differences.kCount; ++i) {
      const float along = dot(n, differences.at[i]);
      lowest = along < least ? differences.at[i] : lowest;
      least = smaller(along, least);
    }
    if (least > distance * length) return true;
    if (change == detail::kMostDirections<kSwept>) return false;
    const Vec3f towards = lowest - n;
    const float share = -dot(n, towards) / squared_norm(towards);
    n = n + smaller(share, 1.0F) * towards;
  }
}

}  // namespace softcd
