#include "mesh_tools/exact_intersection.hpp"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>

namespace softcd::mesh_tools {
namespace {

using Rational = boost::multiprecision::cpp_rational;

struct Vec2d {
  double x, y;
};

// Bounds on the rounding error of the determinants below in double precision, as multiples of the sum of the absolute
// values of their products, from Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates (1997). Overflow gives infinity or NaN, which no comparison accepts; where products can underflow, exact
// arithmetic decides.
constexpr double kUnit = 0x1p-53;
constexpr double kBound2d = (3 + 16 * kUnit) * kUnit;
constexpr double kBound3d = (7 + 56 * kUnit) * kUnit;
constexpr double kMayUnderflow = 1e-280;

int sign_of(double value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

int exact_orientation(Vec2d a, Vec2d b, Vec2d c) {
  const Rational cx(c.x);
  const Rational cy(c.y);
  const Rational left = (Rational(a.x) - cx) * (Rational(b.y) - cy);
  const Rational right = (Rational(a.y) - cy) * (Rational(b.x) - cx);
  return left.compare(right);
}

/// Returns a positive number where a, b, c turn counterclockwise.
int orientation(Vec2d a, Vec2d b, Vec2d c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double magnitude = std::abs(left) + std::abs(right);
  const double determinant = left - right;
  if (magnitude > kMayUnderflow && std::abs(determinant) > kBound2d * magnitude) return sign_of(determinant);
  return exact_orientation(a, b, c);
}

int exact_orientation(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
  const auto difference = [](double x, double y) { return Rational(Rational(x) - Rational(y)); };
  const Rational ax = difference(a.x, d.x);
  const Rational ay = difference(a.y, d.y);
  const Rational az = difference(a.z, d.z);
  const Rational bx = difference(b.x, d.x);
  const Rational by = difference(b.y, d.y);
  const Rational bz = difference(b.z, d.z);
  const Rational cx = difference(c.x, d.x);
  const Rational cy = difference(c.y, d.y);
  const Rational cz = difference(c.z, d.z);
  const Rational determinant = az * (bx * cy - cx * by) + bz * (cx * ay - ax * cy) + cz * (ax * by - bx * ay);
  return determinant.sign();
}

/// Returns the sign of the volume of a, b, c, d; exactly 0 where they are coplanar.
int orientation(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
  const Vec3d u = a - d;
  const Vec3d v = b - d;
  const Vec3d w = c - d;
  const double vw = v.x * w.y;
  const double wv = w.x * v.y;
  const double wu = w.x * u.y;
  const double uw = u.x * w.y;
  const double uv = u.x * v.y;
  const double vu = v.x * u.y;
  const double determinant = u.z * (vw - wv) + v.z * (wu - uw) + w.z * (uv - vu);
  const double magnitude = (std::abs(vw) + std::abs(wv)) * std::abs(u.z) +
                           (std::abs(wu) + std::abs(uw)) * std::abs(v.z) +
                           (std::abs(uv) + std::abs(vu)) * std::abs(w.z);
  if (magnitude > kMayUnderflow && std::abs(determinant) > kBound3d * magnitude) return sign_of(determinant);
  // Only equal numbers have the difference 0. Configurations that are flat along an axis are common, and this is much
  // faster.
  for (int axis = 0; axis < 3; ++axis) {
    if (u[axis] == 0 && v[axis] == 0 && w[axis] == 0) return 0;
  }
  return exact_orientation(a, b, c, d);
}

/// Returns whether c, a point of the line through a and b, or of both if they are equal, is between them.
bool is_between(Vec2d a, Vec2d b, Vec2d c) {
  return std::min(a.x, b.x) <= c.x && c.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= c.y &&
         c.y <= std::max(a.y, b.y);
}

bool segments_intersect(Vec2d p, Vec2d q, Vec2d a, Vec2d b) {
  const int p_side = orientation(a, b, p);
  const int q_side = orientation(a, b, q);
  const int a_side = orientation(p, q, a);
  const int b_side = orientation(p, q, b);
  if (p_side * q_side < 0 && a_side * b_side < 0) return true;
  return (p_side == 0 && is_between(a, b, p)) || (q_side == 0 && is_between(a, b, q)) ||
         (a_side == 0 && is_between(p, q, a)) || (b_side == 0 && is_between(p, q, b));
}

bool is_strictly_inside(Vec2d p, const std::array<Vec2d, 3>& t) {
  const int first = orientation(t[0], t[1], p);
  return first != 0 && orientation(t[1], t[2], p) == first && orientation(t[2], t[0], p) == first;
}

bool intersects(Vec2d p, Vec2d q, const std::array<Vec2d, 3>& t) {
  return segments_intersect(p, q, t[0], t[1]) || segments_intersect(p, q, t[1], t[2]) ||
         segments_intersect(p, q, t[2], t[0]) || is_strictly_inside(p, t);
}

Vec2d without_axis(Vec3d v, int axis) {
  return {v[(axis + 1) % 3], v[(axis + 2) % 3]};
}

// In at least one of the three projections, different points of the common plane stay different, and the result is
// right. Features that meet have projections that meet.
bool intersects_in_plane(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& t) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<Vec2d, 3> projected = {without_axis(t[0], axis), without_axis(t[1], axis),
                                            without_axis(t[2], axis)};
    if (!intersects(without_axis(p, axis), without_axis(q, axis), projected)) return false;
  }
  return true;
}

}  // namespace

bool intersects(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  const int p_side = orientation(a, b, c, p);
  const int q_side = orientation(a, b, c, q);
  if (p_side * q_side > 0) return false;
  const auto [low, high] = std::minmax({orientation(p, q, a, b), orientation(p, q, b, c), orientation(p, q, c, a)});
  if (p_side != 0 || q_side != 0) return low >= 0 || high <= 0;
  // All are coplanar, unless the triangle is degenerate.
  return low == 0 && high == 0 && intersects_in_plane(p, q, triangle);
}

bool passes_through(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  if (orientation(a, b, c, p) * orientation(a, b, c, q) >= 0) return false;
  const int first = orientation(p, q, a, b);
  return first != 0 && orientation(p, q, b, c) == first && orientation(p, q, c, a) == first;
}

}  // namespace softcd::mesh_tools
