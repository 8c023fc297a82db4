#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Returns the projection of p onto one of the nine axes, rounded once.
template <int kAxis>
SOFTCD_HD constexpr float project(Vec3f p) {
  if constexpr (kAxis < 3) {
    return p[kAxis];
  } else {
    constexpr int kFirst = kAxis == 5 || kAxis == 8 ? 1 : 0;
    constexpr int kSecond = kAxis == 3 || kAxis == 6 ? 1 : 2;
    return kAxis < 6 ? p[kFirst] + p[kSecond] : p[kFirst] - p[kSecond];
  }
}

/// A moving set of points: their positions at both ends of the step.
template <int kCount>
struct PointMotion {
  Vec3f t0[kCount];
  Vec3f t1[kCount];
};

struct Interval {
  float lo, hi;
};

/// Returns the interval of the projections of the points begin <= i < end.
template <int kAxis>
SOFTCD_HD constexpr Interval project(const Vec3f* points, int begin, int end) {
  Interval interval = {project<kAxis>(points[begin]), project<kAxis>(points[begin])};
  for (int i = begin + 1; i < end; ++i) {
    interval.lo = smaller(interval.lo, project<kAxis>(points[i]));
    interval.hi = larger(interval.hi, project<kAxis>(points[i]));
  }
  return interval;
}

template <bool kSwept, int kAxis, int kSplit, int kCount>
SOFTCD_HD bool apart_on_axis(const PointMotion<kCount>& points, float distance) {
  const Interval a_t1 = project<kAxis>(points.t1, 0, kSplit);
  const Interval b_t1 = project<kAxis>(points.t1, kSplit, kCount);
  bool is_below = outward_up(a_t1.hi + distance) < b_t1.lo;
  bool is_above = outward_up(b_t1.hi + distance) < a_t1.lo;
  if constexpr (kSwept) {
    const Interval a_t0 = project<kAxis>(points.t0, 0, kSplit);
    const Interval b_t0 = project<kAxis>(points.t0, kSplit, kCount);
    is_below &= outward_up(a_t0.hi + distance) < b_t0.lo;
    is_above &= outward_up(b_t0.hi + distance) < a_t0.lo;
  }
  return is_below | is_above;
}

/// Returns whether the first kSplit points lie more than `distance` beyond the others along x, y or z. If kSwept, at
/// both ends of a straight-line motion and hence throughout; else at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_straight_axes(const PointMotion<kCount>& points, AxisDistance distance) {
  const bool x = apart_on_axis<kSwept, 0, kSplit>(points, distance.straight);
  const bool y = apart_on_axis<kSwept, 1, kSplit>(points, distance.straight);
  const bool z = apart_on_axis<kSwept, 2, kSplit>(points, distance.straight);
  return x | y | z;
}

/// Returns whether the first kSplit of the points x[v[0]], x[v[1]] ... lie more than `distance`, a straight_distance,
/// beyond the others along x, y or z. If kSwept, at both ends of a straight-line motion and hence throughout; else at
/// t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_straight_axes(const Vec3f* x_t0, const Vec3f* x_t1, const std::uint32_t (&v)[kCount],
                                                float distance) {
  PointMotion<kCount> points{};
  for (int i = 0; i < kCount; ++i) {
    points.t1[i] = x_t1[v[i]];
    points.t0[i] = kSwept ? x_t0[v[i]] : points.t1[i];
  }
  return certainly_apart_on_straight_axes<kSwept, kSplit>(points, {distance, distance});
}

/// Returns whether the first kSplit points lie more than `distance` beyond the others along one of the six diagonal
/// axes. If kSwept, at both ends of a straight-line motion and hence throughout; else at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_diagonal_axes(const PointMotion<kCount>& points, AxisDistance distance) {
  const bool xy = apart_on_axis<kSwept, 3, kSplit>(points, distance.diagonal);
  const bool xz = apart_on_axis<kSwept, 4, kSplit>(points, distance.diagonal);
  const bool yz = apart_on_axis<kSwept, 5, kSplit>(points, distance.diagonal);
  const bool x_y = apart_on_axis<kSwept, 6, kSplit>(points, distance.diagonal);
  const bool x_z = apart_on_axis<kSwept, 7, kSplit>(points, distance.diagonal);
  const bool y_z = apart_on_axis<kSwept, 8, kSplit>(points, distance.diagonal);
  return xy | xz | yz | x_y | x_z | y_z;
}

}  // namespace softcd
