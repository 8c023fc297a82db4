#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/simd.hpp"

namespace softcd {

/// The intervals of moving points at both ends of a straight-line motion, axis by axis.
struct EndVolumes {
  struct alignas(16) Axis {
    float t0_lo, t0_hi, t1_lo, t1_hi;
  };
  Axis axes[kKdopAxes];
};

SOFTCD_HD constexpr EndVolumes end_volumes(const Kdop18& t0, const Kdop18& t1) {
  EndVolumes ends{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    ends.axes[axis] = {t0.lo[axis], t0.hi[axis], t1.lo[axis], t1.hi[axis]};
  }
  return ends;
}

namespace generic {
SOFTCD_HD inline bool certainly_apart_throughout(const EndVolumes& a, const EndVolumes& b) {
  const auto apart_on = [&](int axis) {
    const EndVolumes::Axis on_a = a.axes[axis];
    const EndVolumes::Axis on_b = b.axes[axis];
    return ((on_a.t0_hi < on_b.t0_lo) & (on_a.t1_hi < on_b.t1_lo)) |
           ((on_b.t0_hi < on_a.t0_lo) & (on_b.t1_hi < on_a.t1_lo));
  };
  // Stop early where three axes reject. x, y and z come last, because entries were compared along them already.
  const auto apart_on_three = [&](int first) { return apart_on(first) | apart_on(first + 1) | apart_on(first + 2); };
  return apart_on_three(3) || apart_on_three(6) || apart_on_three(0);
}
}  // namespace generic

/// Returns whether one set lies beyond the other along some axis at both ends of the motion. Along an axis, the
/// distance from the one's highest to the other's lowest point is concave in time. The sets are then apart throughout,
/// however far they move together.
SOFTCD_HD inline bool certainly_apart_throughout(const EndVolumes& a, const EndVolumes& b) {
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
  return generic::certainly_apart_throughout(a, b);
#endif
}

}  // namespace softcd
