#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/exact_sum.hpp"
#include "softcd/math/scalar.hpp"

/// Finds the side of a plane on which a point lies. The result is exact for all finite float32 coordinates: neither the
/// computation in double nor the exact sum that follows when needed leaves double's range. For doubles it is exact
/// unless a product of three coordinates overflows, or a part of one underflows.
namespace softcd {
namespace detail {

/// The 24 products of three coordinates in a determinant of differences: two parts each, or four of doubles.
template <class T>
using DeterminantSum = ExactSum<sizeof(T) == sizeof(float) ? 48 : 96>;

/// Adds left times right, exactly.
template <class Sum>
SOFTCD_HD inline void add_product_of_two(Sum& sum, double left, double right) {
  const double product = left * right;
  sum.add(product_rest(left, right, product));
  sum.add(product);
}

/// Adds sign a b c. The product a b of floats is exact.
SOFTCD_HD inline void add_product(DeterminantSum<float>& sum, double sign, float a, float b, float c) {
  add_product_of_two(sum, sign * (static_cast<double>(a) * static_cast<double>(b)), static_cast<double>(c));
}
SOFTCD_HD inline void add_product(DeterminantSum<double>& sum, double sign, double a, double b, double c) {
  const DoubleDouble left = exact_product(a, b);
  add_product_of_two(sum, sign * left.lo, c);
  add_product_of_two(sum, sign * left.hi, c);
}

/// Adds sign a . (b x c).
template <class T>
SOFTCD_HD inline void add_triple_product(DeterminantSum<T>& sum, double sign, Vec3<T> a, Vec3<T> b, Vec3<T> c) {
  for (int axis = 0; axis < 3; ++axis) {
    const int next = axis == 2 ? 0 : axis + 1;
    const int last = axis == 0 ? 2 : axis - 1;
    add_product(sum, sign, a[axis], b[next], c[last]);
    add_product(sum, -sign, a[axis], b[last], c[next]);
  }
}

template <class T>
SOFTCD_HD_LONG inline int exact_orientation(Vec3<T> a, Vec3<T> b, Vec3<T> c, Vec3<T> d) {
  DeterminantSum<T> sum;
  add_triple_product<T>(sum, 1.0, a, b, c);
  add_triple_product<T>(sum, -1.0, d, b, c);
  add_triple_product<T>(sum, -1.0, a, d, c);
  add_triple_product<T>(sum, -1.0, a, b, d);
  return sum.sign();
}

}  // namespace detail

/// Returns the sign of (a - d) . ((b - d) x (c - d)); exactly 0 where the four points are coplanar.
template <class T>
SOFTCD_HD inline int orientation(Vec3<T> a, Vec3<T> b, Vec3<T> c, Vec3<T> d) {
  const Vec3d from = vec3_cast<double>(d);
  const Vec3d u = vec3_cast<double>(a) - from;
  const Vec3d v = vec3_cast<double>(b) - from;
  const Vec3d w = vec3_cast<double>(c) - from;
  const double vw = v.x * w.y;
  const double wv = v.y * w.x;
  const double wu = w.x * u.y;
  const double uw = w.y * u.x;
  const double uv = u.x * v.y;
  const double vu = u.y * v.x;
  const double determinant = u.z * (vw - wv) + v.z * (wu - uw) + w.z * (uv - vu);
  const double size = (magnitude(vw) + magnitude(wv)) * magnitude(u.z) +
                      (magnitude(wu) + magnitude(uw)) * magnitude(v.z) +
                      (magnitude(uv) + magnitude(vu)) * magnitude(w.z);
  // Error bound of the determinant (Shewchuk 1997). No difference of unequal numbers is 0, nor is a product of such
  // differences.
  constexpr double kUnit = 0x1p-53;
  constexpr double kBound = (7.0 + 56.0 * kUnit) * kUnit;
  if (magnitude(determinant) > kBound * size) return determinant > 0.0 ? 1 : -1;
  return size == 0.0 ? 0 : detail::exact_orientation(a, b, c, d);
}

}  // namespace softcd
