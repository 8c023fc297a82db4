#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/exact_sum.hpp"
#include "softcd/math/scalar.hpp"

/// Finds the side of a plane on which a point lies. The result is exact for all finite float32 coordinates: neither the
/// computation in double nor the exact sum that follows when needed leaves double's range.
namespace softcd {
namespace detail {

/// The 24 products of three coordinates in a determinant of differences, two parts each.
using DeterminantSum = ExactSum<48>;

/// Adds sign a b c; a b is exact.
SOFTCD_HD inline void add_product(DeterminantSum& sum, double sign, float a, float b, float c) {
  const double left = static_cast<double>(a) * static_cast<double>(b);
  const auto right = static_cast<double>(c);
  const double product = left * right;
  sum.add(sign * product_rest(left, right, product));
  sum.add(sign * product);
}

/// Adds sign a . (b x c).
SOFTCD_HD inline void add_triple_product(DeterminantSum& sum, double sign, Vec3f a, Vec3f b, Vec3f c) {
  for (int axis = 0; axis < 3; ++axis) {
    const int next = axis == 2 ? 0 : axis + 1;
    const int last = axis == 0 ? 2 : axis - 1;
    add_product(sum, sign, a[axis], b[next], c[last]);
    add_product(sum, -sign, a[axis], b[last], c[next]);
  }
}

SOFTCD_HD_LONG inline int exact_orientation(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
  DeterminantSum sum;
  add_triple_product(sum, 1.0, a, b, c);
  add_triple_product(sum, -1.0, d, b, c);
  add_triple_product(sum, -1.0, a, d, c);
  add_triple_product(sum, -1.0, a, b, d);
  return sum.sign();
}

}  // namespace detail

/// Returns the sign of (a - d) . ((b - d) x (c - d)); exactly 0 where the four points are coplanar.
SOFTCD_HD inline int orientation(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
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
