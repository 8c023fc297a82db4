#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/math/simd.hpp"

namespace softcd {

/// Number of axes of an 18-DOP (Klosowski et al. 1998): x, y, z, x+y, x+z, y+z, x-y, x-z, y-z.
constexpr int kKdopAxes = 9;

/// Intervals of a point set along the nine axes. The diagonal axes are not normalised: their unit is
/// sqrt(2) times shorter than the coordinates'. Aligned so that it moves in 16-byte pieces.
struct alignas(16) Kdop18 {
  float lo[kKdopAxes];
  float hi[kKdopAxes];
};

/// A value below x by one to two units in the last place (above for outward_up): undoes any single rounding.
SOFTCD_HD inline float outward_down(float x) {
  return x - (magnitude(x) * 1.1920929e-7F + 1.1754944e-38F);
}
SOFTCD_HD inline float outward_up(float x) {
  return x + (magnitude(x) * 1.1920929e-7F + 1.1754944e-38F);
}

/// Contains nothing and overlaps nothing; extending it by a point gives that point's volume.
SOFTCD_HD inline Kdop18 empty_kdop() {
  Kdop18 dop{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = 3.402823466e+38F;
    dop.hi[axis] = -3.402823466e+38F;
  }
  return dop;
}

SOFTCD_HD constexpr bool is_empty(const Kdop18& dop) {
  return dop.hi[0] < dop.lo[0];
}

/// Each projection is rounded once, hence monotone: volumes of touching points overlap without any padding.
SOFTCD_HD inline void extend(Kdop18& dop, Vec3f p) {
  const float projection[kKdopAxes] = {p.x, p.y, p.z, p.x + p.y, p.x + p.z, p.y + p.z, p.x - p.y, p.x - p.z, p.y - p.z};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = smaller(dop.lo[axis], projection[axis]);
    dop.hi[axis] = larger(dop.hi[axis], projection[axis]);
  }
}

namespace generic {
SOFTCD_HD inline Kdop18 merged(const Kdop18& a, const Kdop18& b) {
  Kdop18 both{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    both.lo[axis] = smaller(a.lo[axis], b.lo[axis]);
    both.hi[axis] = larger(a.hi[axis], b.hi[axis]);
  }
  return both;
}
}  // namespace generic

/// The volume that holds both.
SOFTCD_HD inline Kdop18 merged(const Kdop18& a, const Kdop18& b) {
#ifdef SOFTCD_SSE2
  Kdop18 both;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  const auto merge_four = [&](int axis) {
    _mm_storeu_ps(both.lo + axis, _mm_min_ps(_mm_loadu_ps(a.lo + axis), _mm_loadu_ps(b.lo + axis)));
    _mm_storeu_ps(both.hi + axis, _mm_max_ps(_mm_loadu_ps(a.hi + axis), _mm_loadu_ps(b.hi + axis)));
  };
  merge_four(0);
  merge_four(4);
  merge_four(5);
  return both;
#else
  return generic::merged(a, b);
#endif
}

SOFTCD_HD inline float furthest_coordinate(const Kdop18& dop) {
  float furthest = 0.0F;
  for (int axis = 0; axis < 3; ++axis) {
    furthest = larger(furthest, larger(magnitude(dop.lo[axis]), magnitude(dop.hi[axis])));
  }
  return furthest;
}

/// A distance as it appears along the axes, at least: `diagonal` also covers that projections onto diagonals are
/// rounded.
struct Reach {
  float straight, diagonal;
};

SOFTCD_HD constexpr float straight_reach(float distance) {
  return distance > 0.0F ? distance : 0.0F;
}

/// For points with coordinates up to `furthest`. A distance of 0 needs no slack, since projections are monotone.
SOFTCD_HD inline Reach reach_of(float distance, float furthest) {
  if (!(distance > 0.0F)) return {0.0F, 0.0F};
  return {distance, outward_up(distance * 1.41421357F) + 8.0F * 1.1920929e-7F * furthest};
}

/// Grows the volume by a ball of radius `radius`, rounded outward. Nothing changes when the radius is 0.
SOFTCD_HD inline void inflate(Kdop18& dop, float radius) {
  if (!(radius > 0.0F) || is_empty(dop)) return;
  const Reach reach = reach_of(radius, furthest_coordinate(dop));
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    const float growth = axis < 3 ? reach.straight : reach.diagonal;
    dop.lo[axis] = outward_down(dop.lo[axis] - growth);
    dop.hi[axis] = outward_up(dop.hi[axis] + growth);
  }
}

namespace generic {
SOFTCD_HD inline Kdop18 grown_volume(const Vec3f (&points)[3], float radius) {
  Kdop18 dop = empty_kdop();
  for (const Vec3f& point : points) extend(dop, point);
  inflate(dop, radius);
  return dop;
}
}  // namespace generic

#ifdef SOFTCD_SSE2
namespace detail {

/// x, y, z, 0.
inline __m128 lanes_of(const Vec3f& p) {
  const __m128 xy = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&p.x)));
  return _mm_movelh_ps(xy, _mm_load_ss(&p.z));
}

inline void store_three(float* out, __m128 x) {
  _mm_storel_pi(reinterpret_cast<__m64*>(out), x);
  _mm_store_ss(out + 2, _mm_movehl_ps(x, x));
}

inline __m128 magnitudes(__m128 x) {
  return _mm_andnot_ps(_mm_set1_ps(-0.0F), x);
}
inline __m128 outward_by(__m128 x) {
  return _mm_add_ps(_mm_mul_ps(magnitudes(x), _mm_set1_ps(1.1920929e-7F)), _mm_set1_ps(1.1754944e-38F));
}
inline __m128 outward_down(__m128 x) {
  return _mm_sub_ps(x, outward_by(x));
}
inline __m128 outward_up(__m128 x) {
  return _mm_add_ps(x, outward_by(x));
}

/// Intervals along three axes.
struct ThreeAxes {
  __m128 lo = _mm_set1_ps(3.402823466e+38F);
  __m128 hi = _mm_set1_ps(-3.402823466e+38F);

  void extend(__m128 projections) {
    lo = _mm_min_ps(lo, projections);
    hi = _mm_max_ps(hi, projections);
  }
  void inflate(float growth) {
    lo = outward_down(_mm_sub_ps(lo, _mm_set1_ps(growth)));
    hi = outward_up(_mm_add_ps(hi, _mm_set1_ps(growth)));
  }
  float furthest() const {
    const __m128 size = _mm_max_ps(magnitudes(lo), magnitudes(hi));
    const __m128 x = _mm_max_ss(_mm_setzero_ps(), size);
    const __m128 xy = _mm_max_ss(x, _mm_shuffle_ps(size, size, _MM_SHUFFLE(1, 1, 1, 1)));
    return _mm_cvtss_f32(_mm_max_ss(xy, _mm_movehl_ps(size, size)));
  }
};

}  // namespace detail
#endif

/// The volume of a triangle's corners, grown by a ball of this radius.
SOFTCD_HD inline Kdop18 grown_volume(const Vec3f (&points)[3], float radius) {
#ifdef SOFTCD_SSE2
  detail::ThreeAxes straight, sums, differences;
  for (const Vec3f& point : points) {
    const __m128 p = detail::lanes_of(point);
    const __m128 first = _mm_shuffle_ps(p, p, _MM_SHUFFLE(3, 1, 0, 0));
    const __m128 second = _mm_shuffle_ps(p, p, _MM_SHUFFLE(3, 2, 2, 1));
    straight.extend(p);
    sums.extend(_mm_add_ps(first, second));
    differences.extend(_mm_sub_ps(first, second));
  }
  const bool is_empty = _mm_cvtss_f32(straight.hi) < _mm_cvtss_f32(straight.lo);
  if (radius > 0.0F && !is_empty) {
    const Reach reach = reach_of(radius, straight.furthest());
    straight.inflate(reach.straight);
    sums.inflate(reach.diagonal);
    differences.inflate(reach.diagonal);
  }
  Kdop18 dop;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  detail::store_three(dop.lo, straight.lo);
  detail::store_three(dop.lo + 3, sums.lo);
  detail::store_three(dop.lo + 6, differences.lo);
  detail::store_three(dop.hi, straight.hi);
  detail::store_three(dop.hi + 3, sums.hi);
  detail::store_three(dop.hi + 6, differences.hi);
  return dop;
#else
  return generic::grown_volume(points, radius);
#endif
}

namespace generic {
/// By value, so that the device reads them in 16-byte pieces.
SOFTCD_HD inline bool overlap(const Kdop18 a, const Kdop18 b) {
  bool is_apart = false;
  for (int axis = 0; axis < 3; ++axis) is_apart |= (a.hi[axis] < b.lo[axis]) | (b.hi[axis] < a.lo[axis]);
  if (is_apart) return false;
  for (int axis = 3; axis < kKdopAxes; ++axis) is_apart |= (a.hi[axis] < b.lo[axis]) | (b.hi[axis] < a.lo[axis]);
  return !is_apart;
}
}  // namespace generic

SOFTCD_HD inline bool overlap(const Kdop18& a, const Kdop18& b) {
#ifdef SOFTCD_SSE2
  const auto gaps = [&](int axis) {
    const __m128 a_below = _mm_cmplt_ps(_mm_loadu_ps(a.hi + axis), _mm_loadu_ps(b.lo + axis));
    const __m128 b_below = _mm_cmplt_ps(_mm_loadu_ps(b.hi + axis), _mm_loadu_ps(a.lo + axis));
    return _mm_or_ps(a_below, b_below);
  };
  return _mm_movemask_ps(_mm_or_ps(_mm_or_ps(gaps(0), gaps(4)), gaps(5))) == 0;
#else
  return generic::overlap(a, b);
#endif
}

/// The volumes of moving points at both ends of a straight-line motion, axis by axis.
struct EndVolumes {
  struct alignas(16) Axis {
    float t0_lo, t0_hi, t1_lo, t1_hi;
  };
  Axis axes[kKdopAxes];
};

SOFTCD_HD inline EndVolumes end_volumes(const Kdop18& t0, const Kdop18& t1) {
  EndVolumes ends{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    ends.axes[axis] = {t0.lo[axis], t0.hi[axis], t1.lo[axis], t1.hi[axis]};
  }
  return ends;
}

namespace generic {
SOFTCD_HD inline bool apart_throughout(const EndVolumes& a, const EndVolumes& b) {
  const auto apart_on = [&](int axis) {
    const EndVolumes::Axis on_a = a.axes[axis];
    const EndVolumes::Axis on_b = b.axes[axis];
    return ((on_a.t0_hi < on_b.t0_lo) & (on_a.t1_hi < on_b.t1_lo)) |
           ((on_b.t0_hi < on_a.t0_lo) & (on_b.t1_hi < on_a.t1_lo));
  };
  // What the first three axes reject need not be read further.
  bool is_apart = false;
  for (int axis = 0; axis < 3; ++axis) is_apart |= apart_on(axis);
  if (is_apart) return true;
  for (int axis = 3; axis < kKdopAxes; ++axis) is_apart |= apart_on(axis);
  return is_apart;
}
}  // namespace generic

/// Whether, along some axis, one lies beyond the other at both ends. The distance along an axis from the one's highest
/// to the other's lowest point is concave in time, so what the volumes hold is then apart throughout, however far the
/// two move together.
SOFTCD_HD inline bool apart_throughout(const EndVolumes& a, const EndVolumes& b) {
#ifdef SOFTCD_SSE2
  // Lanes: a's highest point below b's lowest at t0 and at t1, b's below a's.
  const auto below = [&](int axis) {
    const __m128 on_a = _mm_load_ps(&a.axes[axis].t0_lo);
    const __m128 on_b = _mm_load_ps(&b.axes[axis].t0_lo);
    return _mm_cmplt_ps(_mm_shuffle_ps(on_a, on_b, _MM_SHUFFLE(3, 1, 3, 1)),
                        _mm_shuffle_ps(on_b, on_a, _MM_SHUFFLE(2, 0, 2, 0)));
  };
  const auto apart_on_two = [&](int axis) {
    const __m128 first = below(axis);
    const __m128 second = below(axis + 1);
    return _mm_and_ps(_mm_shuffle_ps(first, second, _MM_SHUFFLE(2, 0, 2, 0)),
                      _mm_shuffle_ps(first, second, _MM_SHUFFLE(3, 1, 3, 1)));
  };
  __m128 is_apart = apart_on_two(0);
  for (int axis = 2; axis < 8; axis += 2) is_apart = _mm_or_ps(is_apart, apart_on_two(axis));
  return _mm_movemask_ps(_mm_or_ps(is_apart, apart_on_two(7))) != 0;
#else
  return generic::apart_throughout(a, b);
#endif
}

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

/// Of points begin <= i < end.
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
SOFTCD_HD bool apart_on_axis(const PointMotion<kCount>& points, float reach) {
  const Interval a_t1 = project<kAxis>(points.t1, 0, kSplit);
  const Interval b_t1 = project<kAxis>(points.t1, kSplit, kCount);
  bool is_below = outward_up(a_t1.hi + reach) < b_t1.lo;
  bool is_above = outward_up(b_t1.hi + reach) < a_t1.lo;
  if constexpr (kSwept) {
    const Interval a_t0 = project<kAxis>(points.t0, 0, kSplit);
    const Interval b_t0 = project<kAxis>(points.t0, kSplit, kCount);
    is_below &= outward_up(a_t0.hi + reach) < b_t0.lo;
    is_above &= outward_up(b_t0.hi + reach) < a_t0.lo;
  }
  return is_below | is_above;
}

/// Whether, along x, y or z, the first kSplit points lie more than `reach` beyond the others at both ends of a
/// straight-line motion, and so throughout; unless continuous, at t1.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool apart_on_straight_axes(const PointMotion<kCount>& points, Reach reach) {
  const bool x = apart_on_axis<kSwept, 0, kSplit>(points, reach.straight);
  const bool y = apart_on_axis<kSwept, 1, kSplit>(points, reach.straight);
  const bool z = apart_on_axis<kSwept, 2, kSplit>(points, reach.straight);
  return x | y | z;
}

namespace generic {
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool apart_on_straight_axes(const Vec3f* x_t0, const Vec3f* x_t1, const std::uint32_t (&v)[kCount],
                                      float reach) {
  PointMotion<kCount> points{};
  for (int i = 0; i < kCount; ++i) {
    points.t1[i] = x_t1[v[i]];
    points.t0[i] = kSwept ? x_t0[v[i]] : points.t1[i];
  }
  return softcd::apart_on_straight_axes<kSwept, kSplit>(points, {reach, reach});
}
}  // namespace generic

#ifdef SOFTCD_SSE2
namespace detail {

/// A box, its fourth lanes 0.
struct BoxLanes {
  __m128 lo, hi;
};

/// Of the points x[v[kBegin]] to x[v[kEnd - 1]].
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

/// Along which axes a ends more than `reach` before b begins.
inline __m128 below(const BoxLanes& a, const BoxLanes& b, __m128 reach) {
  return _mm_cmplt_ps(outward_up(_mm_add_ps(a.hi, reach)), b.lo);
}

}  // namespace detail
#endif

/// The same of the points x[v[0]], x[v[1]] ...; `reach` is a straight_reach.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool apart_on_straight_axes(const Vec3f* x_t0, const Vec3f* x_t1, const std::uint32_t (&v)[kCount],
                                      float reach) {
#ifdef SOFTCD_SSE2
  // The fourth lanes' sum must not come near the subnormal numbers, which are slow.
  const __m128 reaches = _mm_setr_ps(reach, reach, reach, 1.0F);
  const detail::BoxLanes a_t1 = detail::box_lanes<0, kSplit>(x_t1, v);
  const detail::BoxLanes b_t1 = detail::box_lanes<kSplit, kCount>(x_t1, v);
  __m128 is_below = detail::below(a_t1, b_t1, reaches);
  __m128 is_above = detail::below(b_t1, a_t1, reaches);
  if constexpr (kSwept) {
    const detail::BoxLanes a_t0 = detail::box_lanes<0, kSplit>(x_t0, v);
    const detail::BoxLanes b_t0 = detail::box_lanes<kSplit, kCount>(x_t0, v);
    is_below = _mm_and_ps(is_below, detail::below(a_t0, b_t0, reaches));
    is_above = _mm_and_ps(is_above, detail::below(b_t0, a_t0, reaches));
  }
  return (_mm_movemask_ps(_mm_or_ps(is_below, is_above)) & 7) != 0;
#else
  return generic::apart_on_straight_axes<kSwept, kSplit>(x_t0, x_t1, v, reach);
#endif
}

/// The same along the six diagonal axes.
template <bool kSwept, int kSplit, int kCount>
SOFTCD_HD bool apart_on_diagonal_axes(const PointMotion<kCount>& points, Reach reach) {
  const bool xy = apart_on_axis<kSwept, 3, kSplit>(points, reach.diagonal);
  const bool xz = apart_on_axis<kSwept, 4, kSplit>(points, reach.diagonal);
  const bool yz = apart_on_axis<kSwept, 5, kSplit>(points, reach.diagonal);
  const bool x_y = apart_on_axis<kSwept, 6, kSplit>(points, reach.diagonal);
  const bool x_z = apart_on_axis<kSwept, 7, kSplit>(points, reach.diagonal);
  const bool y_z = apart_on_axis<kSwept, 8, kSplit>(points, reach.diagonal);
  return xy | xz | yz | x_y | x_z | y_z;
}

/// Axis-aligned box, the first three axes of the 18-DOP.
struct Box {
  Vec3f lo, hi;
};

SOFTCD_HD constexpr Box box_of(Vec3f p) {
  return {p, p};
}

SOFTCD_HD constexpr Box box_of(const Kdop18& dop) {
  return {{dop.lo[0], dop.lo[1], dop.lo[2]}, {dop.hi[0], dop.hi[1], dop.hi[2]}};
}

SOFTCD_HD constexpr Box merged(const Box& a, const Box& b) {
  return {{smaller(a.lo.x, b.lo.x), smaller(a.lo.y, b.lo.y), smaller(a.lo.z, b.lo.z)},
          {larger(a.hi.x, b.hi.x), larger(a.hi.y, b.hi.y), larger(a.hi.z, b.hi.z)}};
}

SOFTCD_HD inline Box inflated(const Box& box, float radius) {
  if (!(radius > 0.0F)) return box;
  return {{outward_down(box.lo.x - radius), outward_down(box.lo.y - radius), outward_down(box.lo.z - radius)},
          {outward_up(box.hi.x + radius), outward_up(box.hi.y + radius), outward_up(box.hi.z + radius)}};
}

/// All comparisons are made: boxes that are tried overlap often enough that one branch is cheaper than six.
SOFTCD_HD constexpr bool overlap(const Box& a, const Box& b) {
  return (a.lo.x <= b.hi.x) & (b.lo.x <= a.hi.x) & (a.lo.y <= b.hi.y) & (b.lo.y <= a.hi.y) & (a.lo.z <= b.hi.z) &
         (b.lo.z <= a.hi.z);
}

SOFTCD_HD constexpr bool overlap(const Box& box, const Kdop18& dop) {
  return box.lo.x <= dop.hi[0] && dop.lo[0] <= box.hi.x && box.lo.y <= dop.hi[1] && dop.lo[1] <= box.hi.y &&
         box.lo.z <= dop.hi[2] && dop.lo[2] <= box.hi.z;
}

}  // namespace softcd
