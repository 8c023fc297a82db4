#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/coordinate_range.hpp"
#include "softcd/math/exact_sum.hpp"
#include "softcd/math/scalar.hpp"

/// The watertight test of Woop, Benthin and Wald, Watertight Ray/Triangle Intersection (JCGT 2013), in double.
/// - Vertices are sheared into a plane across the ray, in which the ray is the origin. The ray meets a triangle when
///   the origin is on one side of all images of the triangle's sides.
/// - Images are rounded. Where their error might decide, the ray's position relative to the side itself is computed
///   exactly.
/// - The triangle on the other side of an edge gets the opposite sign. So no ray passes between triangles that share an
///   edge, or around a vertex.
/// - A triangle that is seen edge-on has the ray on none of its sides.
namespace softcd {

/// A ray prepared for the test, relative to the scene's origin.
struct ShearedRay {
  Vec3d origin;
  Vec3d direction;
  int kx, ky, kz;  ///< kz: the direction's largest component
  double sx, sy;
};

/// Prepares a ray. Returns false for a ray that hits nothing: see Ray.
SOFTCD_HD inline bool shear(const Ray& ray, Vec3d scene_origin, ShearedRay& sheared) {
  const Vec3d d = ray.direction;
  sheared.origin = ray.origin - scene_origin;
  sheared.direction = d;
  const bool is_finite = magnitude(d.x) <= DBL_MAX && magnitude(d.y) <= DBL_MAX && magnitude(d.z) <= DBL_MAX;
  if (!is_finite || !is_usable(sheared.origin) || !(max_norm(d) > 0.0) || !(ray.t_min <= ray.t_max)) return false;
  sheared.kz = magnitude(d.x) >= magnitude(d.y) ? (magnitude(d.x) >= magnitude(d.z) ? 0 : 2)
                                                : (magnitude(d.y) >= magnitude(d.z) ? 1 : 2);
  sheared.kx = sheared.kz == 2 ? 0 : sheared.kz + 1;
  sheared.ky = sheared.kx == 2 ? 0 : sheared.kx + 1;
  sheared.sx = d[sheared.kx] / d[sheared.kz];
  sheared.sy = d[sheared.ky] / d[sheared.kz];
  return true;
}

/// Returns a vertex's image, and as z its distance along the ray.
SOFTCD_HD inline Vec3d sheared_vertex(const ShearedRay& ray, Vec3f vertex) {
  const Vec3d a = vec3_cast<double>(vertex) - ray.origin;
  const double z = a[ray.kz];
  return {a[ray.kx] - ray.sx * z, a[ray.ky] - ray.sy * z, z};
}

namespace detail {

/// A triangle's side without rounding: its start relative to the ray's origin, and the vector from there to its end.
struct ExactSide {
  DoubleDouble start[3], way[3];
};

/// Returns direction . (start x way), rounded, with the exact sign unless it underflows.
SOFTCD_HD_LONG inline double exact_volume(const Vec3d& direction, const ExactSide& side) {
  ExactSum<96> sum;
  SOFTCD_NOT_UNROLLED
  for (int axis = 0; axis < 3; ++axis) {
    const int next = axis == 2 ? 0 : axis + 1;
    const int last = axis == 0 ? 2 : axis - 1;
    SOFTCD_NOT_UNROLLED
    for (int part = 0; part < 8; ++part) {
      const bool is_swapped = part >= 4;
      const DoubleDouble& start = side.start[is_swapped ? last : next];
      const DoubleDouble& way = side.way[is_swapped ? next : last];
      const DoubleDouble product =
          exact_product((part & 1) != 0 ? start.lo : start.hi, (part & 2) != 0 ? way.lo : way.hi);
      const double factor = is_swapped ? -direction[axis] : direction[axis];
      const DoubleDouble lower = exact_product(product.lo, factor);
      const DoubleDouble upper = exact_product(product.hi, factor);
      sum.add(lower.lo);
      sum.add(lower.hi);
      sum.add(upper.lo);
      sum.add(upper.hi);
    }
  }
  return sum.value();
}

/// Returns whether the ray begins at the vertex or passes it at t = 1: rays between vertices often do.
SOFTCD_HD inline bool is_end_of(const ShearedRay& ray, Vec3f vertex) {
  bool is_begin = true;
  bool is_end = true;
  SOFTCD_NOT_UNROLLED
  for (int axis = 0; axis < 3; ++axis) {
    const DoubleDouble way = exact_difference(static_cast<double>(vertex[axis]), ray.origin[axis]);
    is_begin &= way.hi == 0.0;
    is_end &= way.hi == ray.direction[axis] && way.lo == 0.0;
  }
  return is_begin || is_end;
}

/// Returns the doubled area of the images of the ray's origin, p and q, within 2^-24 of its value and with the exact
/// sign.
SOFTCD_HD_LONG inline double exact_area(const ShearedRay& ray, Vec3f p, Vec3f q) {
  if (is_end_of(ray, p) || is_end_of(ray, q)) return 0.0;
  const Vec3d direction = safe_scale(max_norm(ray.direction)) * ray.direction;
  ExactSide side;
  double start_size = 0.0;
  double way_size = 0.0;
  double rest = 0.0;
  SOFTCD_NOT_UNROLLED
  for (int axis = 0; axis < 3; ++axis) {
    const auto from = static_cast<double>(p[axis]);
    side.start[axis] = exact_difference(from, ray.origin[axis]);
    side.way[axis] = exact_difference(static_cast<double>(q[axis]), from);
    start_size = larger(start_size, magnitude(side.start[axis].hi));
    way_size = larger(way_size, magnitude(side.way[axis].hi));
    rest = larger(rest, larger(magnitude(side.start[axis].lo), magnitude(side.way[axis].lo)));
  }
  if (ray.sx == 0.0 && ray.sy == 0.0 && rest == 0.0) {
    const DoubleDouble left = exact_product(side.start[ray.kx].hi, side.way[ray.ky].hi);
    const DoubleDouble right = exact_product(side.start[ray.ky].hi, side.way[ray.kx].hi);
    ExactSum<4> area;
    area.add(left.lo);
    area.add(-right.lo);
    area.add(left.hi);
    area.add(-right.hi);
    return area.value();
  }
  DoubleDouble volume{0.0, 0.0};
  SOFTCD_NOT_UNROLLED
  for (int axis = 0; axis < 3; ++axis) {
    const int next = axis == 2 ? 0 : axis + 1;
    const int last = axis == 0 ? 2 : axis - 1;
    const DoubleDouble area = side.start[next] * side.way[last] + -(side.start[last] * side.way[next]);
    volume = volume + area * DoubleDouble{direction[axis], 0.0};
  }
  // The volume's error is below 2^-96 of the size of its terms.
  const double least = 0x1p-72 * (max_norm(direction) * start_size * way_size);
  const double exact = magnitude(volume.hi) > least ? volume.hi : exact_volume(direction, side);
  return exact / direction[ray.kz];
}

}  // namespace detail

/// Returns px qy - py qx.
SOFTCD_HD inline double doubled_area(const Vec3d& p, const Vec3d& q) {
  return p.x * q.y - p.y * q.x;
}

/// Bounds the error of the doubled areas of these images against unrounded images. Let u = 2^-53 and r = |image| + |z|,
/// which bounds the vertex's distance from the origin along an axis.
/// - An image's error is 2 u from subtracting the origin, 3 u from the shear and u from the last subtraction: less than
///   6 u r in all.
/// - An area's error is four times the product of that and the image, plus 4 u of the image's square.
SOFTCD_HD inline double area_error(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double image = larger(larger(larger(magnitude(a.x), magnitude(a.y)), larger(magnitude(b.x), magnitude(b.y))),
                              larger(magnitude(c.x), magnitude(c.y)));
  const double reach = image + larger(larger(magnitude(a.z), magnitude(b.z)), magnitude(c.z));
  return 0x1p-47 * reach * (image + 0x1p-49 * reach);
}

struct RayCrossing {
  double t;
  double weights[3];
};

/// Finds where the ray's line passes through the triangle, borders included. A line in the triangle's plane does not
/// pass through it.
SOFTCD_HD inline bool find_crossing(const ShearedRay& ray, const Vec3f (&x)[3], RayCrossing& crossing) {
  const Vec3d a = sheared_vertex(ray, x[0]);
  const Vec3d b = sheared_vertex(ray, x[1]);
  const Vec3d c = sheared_vertex(ray, x[2]);
  double u = doubled_area(b, c);
  double v = doubled_area(c, a);
  double w = doubled_area(a, b);
  const double lowest = smaller(smaller(u, v), w);
  const double highest = larger(larger(u, v), w);
  const double error = area_error(a, b, c);
  if ((lowest < -error) & (highest > error)) return false;
  double whole = u + v + w;
  // For a triangle that is seen almost edge-on, rounding errors would decide all weights.
  const double least = magnitude(whole) > 0x1p+24 * error ? error : DBL_MAX;
  if (!((lowest > least) | (highest < -least))) {
    if (!(magnitude(u) > least)) u = detail::exact_area(ray, x[1], x[2]);
    if (!(magnitude(v) > least)) v = detail::exact_area(ray, x[2], x[0]);
    if (!(magnitude(w) > least)) w = detail::exact_area(ray, x[0], x[1]);
    const bool has_negative = (u < 0.0) | (v < 0.0) | (w < 0.0);
    const bool has_positive = (u > 0.0) | (v > 0.0) | (w > 0.0);
    if (has_negative == has_positive) return false;
    whole = u + v + w;
  }
  crossing.weights[0] = u / whole;
  crossing.weights[1] = v / whole;
  crossing.weights[2] = w / whole;
  // Interpolated along z, so a triangle across an axis has an exact t.
  const double z = a.z + (crossing.weights[1] * (b.z - a.z) + crossing.weights[2] * (c.z - a.z));
  crossing.t = z / ray.direction[ray.kz];
  return true;
}

}  // namespace softcd
