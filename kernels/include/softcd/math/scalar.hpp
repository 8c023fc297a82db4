#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"

/// Scalars for predicates. Only + - * / sqrt and comparisons occur, each rounded once by IEEE 754, so that host
/// and device return the same bytes (contraction must be off on both).
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

/// b when the comparison is unordered.
template <class T>
SOFTCD_HD constexpr T smaller(T a, T b) {
  return a < b ? a : b;
}

/// b when the comparison is unordered.
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

/// Largest magnitude of a component.
template <class T>
SOFTCD_HD T max_norm(Vec3<T> a) {
  return larger(larger(magnitude(a.x), magnitude(a.y)), magnitude(a.z));
}

/// The direction of a, whose length may be any but 0.
template <class T>
SOFTCD_HD Vec3<T> unit_vector(Vec3<T> a) {
  const T size = max_norm(a);
  const Vec3<T> direction{a.x / size, a.y / size, a.z / size};
  return (T(1) / norm(direction)) * direction;
}

/// The point at t of the straight motion from a to b: exact at t = 0 and t = 1, within 1.5 epsilon of the larger
/// magnitude in between.
template <class T>
SOFTCD_HD Vec3<T> interpolate(Vec3<T> a, Vec3<T> b, T t) {
  return (T(1) - t) * a + t * b;
}

/// A power of two that brings lengths up to `extent` (0, any positive value, or infinity after an overflow) into a
/// range where products of six of them neither overflow nor lose the figures that matter. 1 for ordinary extents:
/// 1e-5 to 2.6e8 in float, 1e-45 to 1e45 in double.
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

/// The length of a, whose squares may be beyond T's range.
template <class T>
SOFTCD_HD T length(Vec3<T> a) {
  const T scale = safe_scale(max_norm(a));
  return scale == T(1) ? norm(a) : norm(scale * a) / scale;
}

/// A value below x by one to two units in the last place (above for outward_up): undoes any single rounding.
SOFTCD_HD inline float outward_down(float x) {
  return x - (magnitude(x) * epsilon<float>() + FLT_MIN);
}
SOFTCD_HD inline float outward_up(float x) {
  return x + (magnitude(x) * epsilon<float>() + FLT_MIN);
}

/// Relative to the largest of the coordinates that a number was made of by a few sums, or products with numbers up to
/// 1: bounds their roundings and that of a projection onto a diagonal of the 18-DOP.
constexpr float kCoordinateError = 8.0F * epsilon<float>();

/// The largest float that does not exceed x, for x from 0 to the largest float.
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
