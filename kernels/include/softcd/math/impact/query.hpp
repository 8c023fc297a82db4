#pragma once

#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/math/cubic.hpp"
#include "softcd/math/impact/motion.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd::detail {

/// Roundings of the cubic's coefficients, relative to the volume: see make_query.
template <class T>
constexpr T kCoefficientError = T(40) * epsilon<T>();
/// Roundings of the cubic's values and of where it is split, relative to the volume. docs/inside/proofs.md bounds them.
template <class T>
constexpr T kCubicError = T(192) * epsilon<T>();
/// Roundings of a height over a plane, of its coefficients too, relative to the volume. docs/inside/proofs.md bounds
/// them.
template <class T>
constexpr T kHeightError = T(64) * epsilon<T>();
/// Roundings of the length of a cross product of two vectors, relative to it.
template <class T>
constexpr T kLengthError = T(32) * epsilon<T>();

/// Returns whether the features' distance may be within reach. Their planes or lines are height / |plane| apart.
/// Returns true when that quotient cannot be computed reliably.
template <class T>
SOFTCD_HD bool may_reach(T height, Vec3<T> plane, T reach) {
  return !(height > T(0) && height * height > reach * reach * squared_norm(plane));
}

/// The smallest usable A B C and B C. Above it, underflow in the squares of other compared values costs less than the
/// allowance for roundings. A, B, C and volumes are defined at make_query.
template <class T>
SOFTCD_HD constexpr T smallest_product() {
  return std::is_same_v<T, float> ? T(0x1p-50) : T(0x1p-480);
}

/// Returns whether the features' planes (or the parallel planes through their lines) are certainly further apart than
/// the margin at one time. make_query bounds the roundings.
template <class T>
SOFTCD_HD bool is_certainly_apart(const RelativePair<T>& pair, T margin) {
  const T size_a = max_norm(pair.a);
  const T size_b = max_norm(pair.b);
  const T size_c = max_norm(pair.c);
  const T volume = size_a * size_b * size_c;
  const Vec3<T> plane = cross(pair.b, pair.c);
  const T height = magnitude(dot(pair.a, plane)) - kCoefficientError<T> * volume;
  const T reach = margin + kDistanceError<T> * (size_a + size_b + size_c);
  const bool has_volume = smaller(volume, size_b * size_c) >= smallest_product<T>();
  return has_volume && !may_reach(height, plane, reach);
}

/// A motion with the cubic of its coplanar times, and what is certain about it.
template <class T>
struct Query {
  Motion<T> motion;
  T scale;
  Cubic<T> cubic;
  T volume;  ///< 0 when it is too small to decide anything
  T side;    ///< sign: a's side of b x c at t0; 0 when it cannot be decided
  bool is_never_coplanar;
  bool may_reach_t0, may_reach_t1;
  bool is_apart_throughout;  ///< decided by the features' planes, or the parallel planes through their lines

  SOFTCD_HD bool is_apart_when_coplanar() const { return is_never_coplanar && !may_reach_t0 && !may_reach_t1; }
};

/// Makes a query from a motion, with bounds on its roundings. With `volume` = A B C, no product of three components
/// exceeds it, and the six terms of a determinant are at most 6 volume.
/// - Coefficients (b1 and b2 taken by thirds) have an error of less than 40 epsilon volume.
/// - Values of the cubic, and the shift by its splits, add to that: in all less than 192 epsilon volume.
///
/// Products that are so small that underflow might add to this count as 0: coplanar all along.
template <class T>
SOFTCD_HD Query<T> make_query(Motion<T> motion) {
  T size_a = larger(max_norm(motion.t0.a), max_norm(motion.t1.a));
  T size_b = larger(max_norm(motion.t0.b), max_norm(motion.t1.b));
  T size_c = larger(max_norm(motion.t0.c), max_norm(motion.t1.c));
  const T scale = safe_scale(larger(larger(size_a, size_b), size_c));
  if (scale != T(1)) {
    motion = {scaled(scale, motion.t0), scaled(scale, motion.t1), scale * motion.margin, T(0)};
    size_a *= scale;
    size_b *= scale;
    size_c *= scale;
  }
  motion.tolerance = kDistanceError<T> * (size_a + size_b + size_c);
  const T volume = size_a * size_b * size_c;
  const bool has_volume = smaller(volume, size_b * size_c) >= smallest_product<T>();
  const T error = kCoefficientError<T> * volume;

  const Vec3<T> plane_t0 = cross(motion.t0.b, motion.t0.c);
  const Vec3<T> plane_t1 = cross(motion.t1.b, motion.t1.c);
  const Vec3<T> plane_mixed = cross(motion.t0.b, motion.t1.c) + cross(motion.t1.b, motion.t0.c);
  const Cubic<T> cubic{dot(motion.t0.a, plane_t0), dot(motion.t1.a, plane_t0) + dot(motion.t0.a, plane_mixed),
                       dot(motion.t1.a, plane_mixed) + dot(motion.t0.a, plane_t1), dot(motion.t1.a, plane_t1)};

  const T lowest = smaller(smaller(cubic.b0, cubic.b3), T(1) / T(3) * smaller(cubic.b1, cubic.b2));
  const T highest = larger(larger(cubic.b0, cubic.b3), T(1) / T(3) * larger(cubic.b1, cubic.b2));
  // b x c is a quadratic with the Bernstein coefficients plane_t0, plane_mixed / 2, plane_t1.
  const T longest = larger(larger(norm(plane_t0), T(0.5) * norm(plane_mixed)), norm(plane_t1));
  // The lengths' own roundings matter only where the reach is below |a|; else the planes are within reach anyway.
  const T threshold = kHeightError<T> * volume + (T(1) + kLengthError<T>)*(motion.reach() * longest);
  return {motion,
          scale,
          cubic,
          has_volume ? volume : T(0),
          has_volume && magnitude(cubic.b0) > error ? cubic.b0 : T(0),
          has_volume && (lowest > error || highest < -error),
          !has_volume || may_reach(magnitude(cubic.b0) - error, plane_t0, motion.reach()),
          !has_volume || may_reach(magnitude(cubic.b3) - error, plane_t1, motion.reach()),
          has_volume && (lowest > threshold || highest < -threshold)};
}

}  // namespace softcd::detail
