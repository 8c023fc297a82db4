#include "reference_distance.hpp"

#include <algorithm>
#include <cmath>

namespace softcd::test {
namespace {

using Vec3l = Vec3<long double>;

long double norm(Vec3l a) {
  return std::sqrt(squared_norm(a));
}

long double point_segment(Vec3l p, Vec3l a, Vec3l b) {
  const Vec3l along = b - a;
  const long double length = squared_norm(along);
  if (length == 0.0L) return norm(p - a);
  const long double t = std::clamp(dot(p - a, along) / length, 0.0L, 1.0L);
  return norm(p - (a + t * along));
}

/// Returns the distance of the two lines if their closest points are inside both edges; infinity otherwise.
long double interior_edge_edge(Vec3l e0, Vec3l e1, Vec3l g0, Vec3l g1) {
  const Vec3l e = e1 - e0;
  const Vec3l g = g1 - g0;
  const Vec3l r = e0 - g0;
  const Vec3l normal = cross(e, g);
  const long double determinant = squared_norm(normal);
  if (determinant == 0.0L) return INFINITY;
  const long double s = dot(cross(g, r), normal) / determinant;
  const long double t = dot(cross(e, r), normal) / determinant;
  if (s < 0.0L || s > 1.0L || t < 0.0L || t > 1.0L) return INFINITY;
  return norm((e0 + s * e) - (g0 + t * g));
}

/// Returns the distance to the plane if the foot of the perpendicular is inside the triangle; infinity otherwise.
long double interior_vertex_triangle(Vec3l v, Vec3l f0, Vec3l f1, Vec3l f2) {
  const Vec3l normal = cross(f1 - f0, f2 - f0);
  const long double area = squared_norm(normal);
  if (area == 0.0L) return INFINITY;
  const long double w0 = dot(cross(f2 - f1, v - f1), normal) / area;
  const long double w1 = dot(cross(f0 - f2, v - f2), normal) / area;
  const long double w2 = 1.0L - w0 - w1;
  if (w0 < 0.0L || w1 < 0.0L || w2 < 0.0L) return INFINITY;
  return norm(v - (w0 * f0 + w1 * f1 + w2 * f2));
}

}  // namespace

long double distance_point_segment(Vec3d p, Vec3d a, Vec3d b) {
  return point_segment(vec3_cast<long double>(p), vec3_cast<long double>(a), vec3_cast<long double>(b));
}

long double distance_vertex_triangle(Vec3d v, Vec3d f0, Vec3d f1, Vec3d f2) {
  const Vec3l p = vec3_cast<long double>(v);
  const Vec3l a = vec3_cast<long double>(f0);
  const Vec3l b = vec3_cast<long double>(f1);
  const Vec3l c = vec3_cast<long double>(f2);
  const long double boundary = std::min({point_segment(p, a, b), point_segment(p, b, c), point_segment(p, c, a)});
  return std::min(boundary, interior_vertex_triangle(p, a, b, c));
}

long double distance_edge_edge(Vec3d e0, Vec3d e1, Vec3d g0, Vec3d g1) {
  const Vec3l a = vec3_cast<long double>(e0);
  const Vec3l b = vec3_cast<long double>(e1);
  const Vec3l c = vec3_cast<long double>(g0);
  const Vec3l d = vec3_cast<long double>(g1);
  const long double ends =
      std::min({point_segment(a, c, d), point_segment(b, c, d), point_segment(c, a, b), point_segment(d, a, b)});
  return std::min(ends, interior_edge_edge(a, b, c, d));
}

}  // namespace softcd::test
