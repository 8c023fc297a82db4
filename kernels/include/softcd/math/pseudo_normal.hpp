#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Returns the arc tangent of x in [0, 1], within 1e-13, by + - * / sqrt alone.
SOFTCD_HD inline double arc_tangent(double x) {
  constexpr int kHalvings = 3;
  for (int i = 0; i < kHalvings; ++i) x = x / (1.0 + square_root(1.0 + x * x));
  const double square = x * x;
  double sum = 0.0;
  for (int k = 8; k >= 0; --k) sum = 1.0 / (2 * k + 1) - square * sum;
  return (1 << kHalvings) * x * sum;
}

/// Returns the angle between two vectors, in [0, pi]; 0 where one of them is 0 (Kahan 2006).
SOFTCD_HD inline double angle_between(Vec3d a, Vec3d b) {
  constexpr double kHalfPi = 1.5707963267948966;
  if (!(max_norm(a) > 0.0) || !(max_norm(b) > 0.0)) return 0.0;
  const Vec3d u = unit_vector(a);
  const Vec3d v = unit_vector(b);
  const double difference = norm(u - v);
  const double sum = norm(u + v);
  const double half = difference <= sum ? arc_tangent(difference / sum) : kHalfPi - arc_tangent(sum / difference);
  return 2.0 * half;
}

/// Returns the unit normal of a triangle; 0 where it has no area.
SOFTCD_HD inline Vec3d triangle_normal(const Vec3d (&x)[3]) {
  const Vec3d across = cross(x[1] - x[0], x[2] - x[0]);
  return max_norm(across) > 0.0 ? unit_vector(across) : Vec3d{0, 0, 0};
}

}  // namespace softcd
