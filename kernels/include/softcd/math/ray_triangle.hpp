#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/coordinate_range.hpp"
#include "softcd/math/exact_sum.hpp"
#include "softcd/math/scalar.hpp"

/// The watertight test of Woop, Benthin and Wald, Watertight Ray/Triangle Intersection (JCGT 2013), in double. Vertices
/// are sheared into a plane across the ray, where the ray is the origin. Each vertex has one image, whichever triangle
/// asks, and on which side of a side's image the origin lies is decided exactly and is the opposite for the triangle on
/// the other side: no ray slips through between triangles that share an edge, or around a vertex.
namespace softcd {

/// A ray as the test wants it, relative to the scene's origin.
struct ShearedRay {
  Vec3d origin;
  Vec3d direction;
  int kx, ky, kz;  ///< kz: the direction's largest component
  double sx, sy;
};

/// False for a ray that hits nothing: see Ray.
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

/// A vertex's image, and how far along the ray it is.
SOFTCD_HD inline Vec3d sheared_vertex(const ShearedRay& ray, Vec3f vertex) {
  const Vec3d a = vec3_cast<double>(vertex) - ray.origin;
  const double z = a[ray.kz];
  return {a[ray.kx] - ray.sx * z, a[ray.ky] - ray.sy * z, z};
}

/// px qy - py qx, of exactly that sign: rounding keeps the products' order or makes them equal. Swapped arguments give
/// exactly the opposite.
SOFTCD_HD inline double doubled_area(const Vec3d& p, const Vec3d& q) {
  const double left = p.x * q.y;
  const double right = p.y * q.x;
  if (left != right || left == 0.0) return left - right;
  return product_rest(p.x, q.y, left) - product_rest(p.y, q.x, right);
}

struct RayCrossing {
  double t;
  double weights[3];
};

/// Where the ray's line passes through the triangle, borders included. A triangle that the line lies in the plane of is
/// not passed through.
SOFTCD_HD inline bool find_crossing(const ShearedRay& ray, const Vec3f (&x)[3], RayCrossing& crossing) {
  const Vec3d a = sheared_vertex(ray, x[0]);
  const Vec3d b = sheared_vertex(ray, x[1]);
  const Vec3d c = sheared_vertex(ray, x[2]);
  const double u = doubled_area(b, c);
  const double v = doubled_area(c, a);
  const double w = doubled_area(a, b);
  const bool has_negative = (u < 0.0) | (v < 0.0) | (w < 0.0);
  const bool has_positive = (u > 0.0) | (v > 0.0) | (w > 0.0);
  if (has_negative == has_positive) return false;
  const double whole = u + v + w;
  crossing.weights[0] = u / whole;
  crossing.weights[1] = v / whole;
  crossing.weights[2] = w / whole;
  // Exact across an axis.
  const double z = a.z + (crossing.weights[1] * (b.z - a.z) + crossing.weights[2] * (c.z - a.z));
  crossing.t = z / ray.direction[ray.kz];
  return true;
}

}  // namespace softcd
