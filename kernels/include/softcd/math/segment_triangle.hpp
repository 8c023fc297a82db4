#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/closest_point.hpp"

namespace softcd {
namespace detail {

/// Returns whether the segment passes from one side of the triangle to the other, as computed.
SOFTCD_HD inline bool passes_through(Vec3d p, Vec3d q, const Vec3d (&t)[3]) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  if (!(dot(normal, p - t[0]) * dot(normal, q - t[0]) < 0.0)) return false;
  const Vec3d along = q - p;
  const Vec3d x[3] = {t[0] - p, t[1] - p, t[2] - p};
  const double first = dot(along, cross(x[0], x[1]));
  const double second = dot(along, cross(x[1], x[2]));
  const double third = dot(along, cross(x[2], x[0]));
  return (first >= 0.0 && second >= 0.0 && third >= 0.0) || (first <= 0.0 && second <= 0.0 && third <= 0.0);
}

SOFTCD_HD inline bool are_within(const ClosestPoints<double>& points, double squared_distance) {
  const double inverse = 1.0 / points.scale;
  return points.squared_distance * inverse * inverse <= squared_distance;
}

}  // namespace detail

/// Returns whether the segment pq is within the distance of the triangle, as computed: by one of its ends, by a side of
/// the triangle, or because it passes through.
SOFTCD_HD inline bool are_segment_and_triangle_within(Vec3d p, Vec3d q, const Vec3d (&t)[3], double squared_distance) {
  if (detail::are_within(closest_points_vertex_triangle(p, t[0], t[1], t[2]), squared_distance)) return true;
  if (detail::are_within(closest_points_vertex_triangle(q, t[0], t[1], t[2]), squared_distance)) return true;
  for (int i = 0; i < 3; ++i) {
    const Vec3d next = t[i == 2 ? 0 : i + 1];
    if (detail::are_within(closest_points_edge_edge(p, q, t[i], next), squared_distance)) return true;
  }
  return detail::passes_through(p, q, t);
}

}  // namespace softcd
