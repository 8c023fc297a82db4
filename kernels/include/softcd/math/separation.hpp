#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/math/simd.hpp"

namespace softcd {

/// The projection of p onto one of the nine axes, rounded once.
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

/// A moving set of points: where each is at both ends of the step.
template <int kCount>
struct PointMotion {
  Vec3f t0[kCount];
  Vec3f t1[kCount];
};

struct Interval {
  float lo, hi;
};

/// Where the points begin <= i < end project to.
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

/// Whether, along x, y or z, the first kSplit points lie more than `distance` beyond the others at both ends of a
/// straight-line motion, and so throughout; unless swept, at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_straight_axes(const PointMotion<kCount>& points, AxisDistance distance) {
  const bool x = apart_on_axis<kSwept, 0, kSplit>(points, distance.straight);
  const bool y = apart_on_axis<kSwept, 1, kSplit>(points, distance.straight);
  const bool z = apart_on_axis<kSwept, 2, kSplit>(points, distance.straight);
  return x | y | z;
}

namespace generic {
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_straight_axes(const Vec3f* x_t0, const Vec3f* x_t1, const std::uint32_t (&v)[kCount],
                                                float distance) {
  PointMotion<kCount> points{};
  for (int i = 0; i < kCount; ++i) {
    points.t1[i] = x_t1[v[i]];
    points.t0[i] = kSwept ? x_t0[v[i]] : points.t1[i];
  }
  return softcd::certainly_apart_on_straight_axes<kSwept, kSplit>(points, {distance, distance});
}
}  // namespace generic

#ifdef SOFTCD_SSE2
namespace detail {

/// A box, its fourth lanes 0.
struct BoxLanes {
  __m128 lo, hi;
};

/// The box of the points x[v[kBegin]] to x[v[kEnd - 1]].
template <int kBegin, int kEnd, int kCount>
inline BoxLanes box_lanes(const Vec3f* x, const std::uint32_t (&v)[kCount]) {
  const __m128 first = lanes_of(x[v[kBegin]]);
  BoxLanes box = {first, first};
  for (int i = kBegin + 1; i < kEnd; ++i) {
    const __m128 p = lanes_of(x[v[i]]);
    box = {_mm_min_ps(box.lo, p), _mm_max_ps(box.hi, p)};
  }
  return box;
}

/// The distance in three lanes. The fourth ones' sum must not come near the subnormal numbers, which are slow.
inline __m128 distances_of(float distance) {
  return _mm_setr_ps(distance, distance, distance, 1.0F);
}

/// Along which axes a ends more than `distance` before b begins.
inline __m128 below(const BoxLanes& a, const BoxLanes& b, __m128 distance) {
  return _mm_cmplt_ps(outward_up(_mm_add_ps(a.hi, distance)), b.lo);
}

}  // namespace detail
#endif

/// Whether, along x, y or z, the first kSplit of the points x[v[0]], x[v[1]] ... lie more than `distance`, which is a
/// straight_distance, beyond the others at both ends of a straight-line motion, and so throughout; unless swept, at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_straight_axes(const Vec3f* x_t0, const Vec3f* x_t1, const std::uint32_t (&v)[kCount],
                                                float distance) {
#ifdef SOFTCD_SSE2
  const __m128 distances = detail::distances_of(distance);
  const detail::BoxLanes a_t1 = detail::box_lanes<0, kSplit>(x_t1, v);
  const detail::BoxLanes b_t1 = detail::box_lanes<kSplit, kCount>(x_t1, v);
  __m128 is_below = detail::below(a_t1, b_t1, distances);
  __m128 is_above = detail::below(b_t1, a_t1, distances);
  if constexpr (kSwept) {
    const detail::BoxLanes a_t0 = detail::box_lanes<0, kSplit>(x_t0, v);
    const detail::BoxLanes b_t0 = detail::box_lanes<kSplit, kCount>(x_t0, v);
    is_below = _mm_and_ps(is_below, detail::below(a_t0, b_t0, distances));
    is_above = _mm_and_ps(is_above, detail::below(b_t0, a_t0, distances));
  }
  return (_mm_movemask_ps(_mm_or_ps(is_below, is_above)) & 7) != 0;
#else
  return generic::certainly_apart_on_straight_axes<kSwept, kSplit>(x_t0, x_t1, v, distance);
#endif
}

namespace generic {
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
}  // namespace generic

#ifdef SOFTCD_SSE2
namespace detail {

/// Boxes of sums, and of differences, of x and y, x and z, y and z.
struct DiagonalLanes {
  BoxLanes sums, differences;
};

template <int kBegin, int kEnd>
inline DiagonalLanes diagonal_lanes(const Vec3f* points) {
  DiagonalLanes lanes;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  for (int i = kBegin; i < kEnd; ++i) {
    const __m128 p = lanes_of(points[i]);
    const __m128 first = _mm_shuffle_ps(p, p, _MM_SHUFFLE(3, 1, 0, 0));
    const __m128 second = _mm_shuffle_ps(p, p, _MM_SHUFFLE(3, 2, 2, 1));
    const __m128 sum = _mm_add_ps(first, second);
    const __m128 difference = _mm_sub_ps(first, second);
    if (i == kBegin) {
      lanes = {{sum, sum}, {difference, difference}};
    } else {
      lanes.sums = {_mm_min_ps(lanes.sums.lo, sum), _mm_max_ps(lanes.sums.hi, sum)};
      lanes.differences = {_mm_min_ps(lanes.differences.lo, difference), _mm_max_ps(lanes.differences.hi, difference)};
    }
  }
  return lanes;
}

/// Along which axes the first kSplit points end before the others begin, and the other way round.
struct DiagonalGaps {
  __m128 below_by_sum, above_by_sum, below_by_difference, above_by_difference;
};

template <int kSplit, int kCount>
inline DiagonalGaps diagonal_gaps(const Vec3f (&points)[kCount], __m128 distances) {
  const DiagonalLanes a = diagonal_lanes<0, kSplit>(points);
  const DiagonalLanes b = diagonal_lanes<kSplit, kCount>(points);
  return {below(a.sums, b.sums, distances), below(b.sums, a.sums, distances),
          below(a.differences, b.differences, distances), below(b.differences, a.differences, distances)};
}

}  // namespace detail
#endif

/// Whether, along one of the six diagonal axes, the first kSplit points lie more than `distance` beyond the others at
/// both ends of a straight-line motion, and so throughout; unless swept, at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool certainly_apart_on_diagonal_axes(const PointMotion<kCount>& points, AxisDistance distance) {
#ifdef SOFTCD_SSE2
  const __m128 distances = detail::distances_of(distance.diagonal);
  detail::DiagonalGaps gaps = detail::diagonal_gaps<kSplit>(points.t1, distances);
  if constexpr (kSwept) {
    const detail::DiagonalGaps at_t0 = detail::diagonal_gaps<kSplit>(points.t0, distances);
    gaps = {_mm_and_ps(gaps.below_by_sum, at_t0.below_by_sum), _mm_and_ps(gaps.above_by_sum, at_t0.above_by_sum),
            _mm_and_ps(gaps.below_by_difference, at_t0.below_by_difference),
            _mm_and_ps(gaps.above_by_difference, at_t0.above_by_difference)};
  }
  const __m128 is_apart = _mm_or_ps(_mm_or_ps(gaps.below_by_sum, gaps.above_by_sum),
                                    _mm_or_ps(gaps.below_by_difference, gaps.above_by_difference));
  return (_mm_movemask_ps(is_apart) & 7) != 0;
#else
  return generic::certainly_apart_on_diagonal_axes<kSwept, kSplit>(points, distance);
#endif
}

}  // namespace softcd
