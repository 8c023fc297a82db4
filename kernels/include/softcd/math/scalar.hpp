#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"

/// Scalar functions for predicates. Only + - * / sqrt and comparisons occur. IEEE 754 rounds each once, so host and
/// device return the same bytes (contraction must be off on both).
namespace softcd {

/// Distance from 1 to the next number; one rounding changes a value by at most half of it.
template <class T>
SOFTCD_HD constexpr T epsilon() {
  if constexpr (std::is_same_v<T, float>) {
    return FLT_EPSILON;
  } else {
    return DBL_EPSILON;
  }
}

/// Returns the smaller number; b when one is NaN.
template <class T>
SOFTCD_HD constexpr T smaller(T a, T b) {
  return a < b ? a : b;
}

/// Returns the larger number; b when one is NaN.
template <class T>
SOFTCD_HD constexpr T larger(T a, T b) {
  return a > b ? a : b;
}

SOFTCD_HD inline float magnitude(float x) {
  return ::fabsf(x);
}
SOFTCD_HD inline double magnitude(double x) {
  return ::fabs(x);
}
SOFTCD_HD inline float square_root(float x) {
  return ::sqrtf(x);
}
SOFTCD_HD inline double square_root(double x) {
  return ::sqrt(x);
}

template <class T>
SOFTCD_HD T norm(Vec3<T> a) {
  return square_root(squared_norm(a));
}

/// Returns the largest magnitude of a component.
template <class T>
SOFTCD_HD T max_norm(Vec3<T> a) {
  return larger(larger(magnitude(a.x), magnitude(a.y)), magnitude(a.z));
}

/// Returns the direction of a, which may have any length but 0.
template <class T>
SOFTCD_HD Vec3<T> unit_vector(Vec3<T> a) {
  const T size = max_norm(a);
  const Vec3<T> direction{a.x / size, a.y / size, a.z / size};
  return (T(1) / norm(direction)) * direction;
}

/// Returns the point at t of the straight motion from a to b. Exact at t = 0 and t = 1; in between within 1.5 epsilon
/// of the larger magnitude.
template <class T>
SOFTCD_HD Vec3<T> interpolate(Vec3<T> a, Vec3<T> b, T t) {
  return (T(1) - t) * a + t * b;
}

/// Returns a power of two that scales lengths up to `extent` into a safe range: products of six of them neither
/// overflow nor lose relevant figures. `extent` may be 0, positive, or infinite after an overflow. Returns 1 for
/// ordinary extents: 1e-5 to 2.6e8 in float, 1e-45 to 1e45 in double.
template <class T>
SOFTCD_HD T safe_scale(T extent) {
  constexpr bool kSingle = std::is_same_v<T, float>;
  constexpr T kLowest = kSingle ? T(0x1p-16) : T(0x1p-150);
  constexpr T kHighest = kSingle ? T(0x1p+28) : T(0x1p+150);
  constexpr T kUp = kSingle ? T(0x1p+40) : T(0x1p+290);
  constexpr T kDown = kSingle ? T(0x1p-40) : T(0x1p-290);
  T scale = T(1);
  if (extent > T(0) && !(extent >= kLowest && extent <= kHighest)) {
    for (int step = 0; step < 3; ++step) {
      const T scaled = extent * scale;
      scale = scaled > kHighest ? scale * kDown : (scaled < kLowest ? scale * kUp : scale);
    }
  }
  return scale;
}

/// Returns the length of a, also where its square is beyond T's range.
template <class T>
SOFTCD_HD T length(Vec3<T> a) {
  const T scale = safe_scale(max_norm(a));
  return scale == T(1) ? norm(a) : norm(scale * a) / scale;
}

/// Returns a value one to two units in the last place below x (above x for outward_up), which compensates any single
/// rounding.
SOFTCD_HD inline float outward_down(float x) {
  return x - (magnitude(x) * epsilon<float>() + FLT_MIN);
}
SOFTCD_HD inline float outward_up(float x) {
  return x + (magnitude(x) * epsilon<float>() + FLT_MIN);
}

/// Error of a number that is a sum of few coordinates, or of their products with numbers up to 1, relative to the
/// largest coordinate. Includes the rounding of a projection onto a diagonal of the 18-DOP.
constexpr float kCoordinateError = 8.0F * epsilon<float>();

/// Returns the largest float that does not exceed x, for x from 0 to the largest float.
SOFTCD_HD inline float rounded_down(double x) {
  auto nearest = static_cast<float>(x);
  if (static_cast<double>(nearest) > x) {
    // Positive floats and their bits have the same order.
    std::uint32_t bits = 0;
    memcpy(&bits, &nearest, sizeof(bits));
    --bits;
    memcpy(&nearest, &bits, sizeof(bits));
  }
  return nearest;
}
SOFTCD_HD inline float rounded_down(float x) {
  return x;
}

}  // namespace softcd
