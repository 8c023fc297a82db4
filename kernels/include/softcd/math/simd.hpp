#pragma once

/// SSE2, which every x86-64 processor has, for the few tests that take most of the CPU backend's time. Each has a twin
/// in namespace generic, for the device and for other processors. The twin returns the same for every input: smaller()
/// is _mm_min_ps and larger() is _mm_max_ps, operand by operand, signs of zeros and NaN included.
#if defined(__SSE2__) && !defined(__CUDA_ARCH__)
#define SOFTCD_SSE2
#include <emmintrin.h>

#include <cfloat>

#include "softcd/core/vec3.hpp"

namespace softcd::detail {

/// Returns the lanes x, y, z, 0.
inline __m128 lanes_of(const Vec3f& p) {
  const __m128 xy = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&p.x)));
  return _mm_movelh_ps(xy, _mm_load_ss(&p.z));
}

inline __m128 magnitudes(__m128 x) {
  return _mm_andnot_ps(_mm_set1_ps(-0.0F), x);
}
inline __m128 outward_by(__m128 x) {
  return _mm_add_ps(_mm_mul_ps(magnitudes(x), _mm_set1_ps(FLT_EPSILON)), _mm_set1_ps(FLT_MIN));
}
inline __m128 outward_down(__m128 x) {
  return _mm_sub_ps(x, outward_by(x));
}
inline __m128 outward_up(__m128 x) {
  return _mm_add_ps(x, outward_by(x));
}

}  // namespace softcd::detail
#endif
