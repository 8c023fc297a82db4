#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/intersection.hpp"

namespace softcd {

/// The nearest points of two triangles without common corners.
struct ClosestOnTriangles {
  double squared_distance;  ///< exactly 0 where they intersect; may be rounded to 0 elsewhere
  double weights_a[3];      ///< of the corners; exactly 0 for corners off the edge or corner that the point lies on
  double weights_b[3];
  Vec3d offset;  ///< point of a minus point of b, up to rounding; where they intersect, 0 up to rounding
};

namespace detail {

SOFTCD_HD inline Vec3d weighted(const Vec3d (&x)[3], const double (&weights)[3]) {
  return weights[0] * x[0] + (weights[1] * x[1] + weights[2] * x[2]);
}

/// Collects pairs of features and keeps the nearest points; of equally near pairs, those of the first.
class NearestOfFeatures {
 public:
  SOFTCD_HD NearestOfFeatures(const Vec3d (&a)[3], const Vec3d (&b)[3]) : a_(a), b_(b) {
    for (int i = 0; i < 3; ++i) {
      const ClosestPoints<double> of_a = closest_points_vertex_triangle(a[i], b[0], b[1], b[2]);
      if (is_nearer(of_a, of_a.offset)) set_vertex(best_.weights_a, best_.weights_b, i, of_a);
      const ClosestPoints<double> of_b = closest_points_vertex_triangle(b[i], a[0], a[1], a[2]);
      if (is_nearer(of_b, -of_b.offset)) set_vertex(best_.weights_b, best_.weights_a, i, of_b);
    }
    for (int i = 0; i < 9; ++i) try_edges(i / 3, i % 3);
  }

  SOFTCD_HD const ClosestOnTriangles& best() const { return best_; }

 private:
  SOFTCD_HD bool is_nearer(const ClosestPoints<double>& points, Vec3d offset) {
    const double inverse = 1.0 / points.scale;
    const double squared = points.squared_distance * inverse * inverse;
    if (is_known_ && !(squared < best_.squared_distance)) return false;
    is_known_ = true;
    best_.squared_distance = squared;
    best_.offset = inverse * offset;
    return true;
  }

  static SOFTCD_HD void set_vertex(double (&vertex)[3], double (&triangle)[3], int corner,
                                   const ClosestPoints<double>& points) {
    for (int i = 0; i < 3; ++i) {
      vertex[i] = i == corner ? 1.0 : 0.0;
      triangle[i] = points.weights[1 + i];
    }
  }

  SOFTCD_HD void try_edges(int i, int j) {
    const int i_next = i == 2 ? 0 : i + 1;
    const int j_next = j == 2 ? 0 : j + 1;
    const ClosestPoints<double> points = closest_points_edge_edge(a_[i], a_[i_next], b_[j], b_[j_next]);
    if (!is_nearer(points, points.offset)) return;
    for (int corner = 0; corner < 3; ++corner) best_.weights_a[corner] = best_.weights_b[corner] = 0.0;
    best_.weights_a[i] = points.weights[0];
    best_.weights_a[i_next] = points.weights[1];
    best_.weights_b[j] = points.weights[2];
    best_.weights_b[j_next] = points.weights[3];
  }

  const Vec3d (&a_)[3];
  const Vec3d (&b_)[3];
  ClosestOnTriangles best_{};
  bool is_known_ = false;
};

/// Computes the point where a side of x crosses the plane of t: its weights on x, and the weights of t's nearest point.
SOFTCD_HD inline void set_crossing(const Vec3d (&x)[3], int side, const Vec3d (&t)[3], double (&of_x)[3],
                                   double (&of_t)[3]) {
  const int next = side == 2 ? 0 : side + 1;
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  const double height = dot(normal, x[side] - t[0]);
  const double fall = height - dot(normal, x[next] - t[0]);
  const double along = fall == 0.0 ? 0.0 : smaller(larger(height / fall, 0.0), 1.0);
  for (double& weight : of_x) weight = 0.0;
  of_x[side] = 1.0 - along;
  of_x[next] = along;
  const ClosestPoints<double> points = closest_points_vertex_triangle(weighted(x, of_x), t[0], t[1], t[2]);
  for (int i = 0; i < 3; ++i) of_t[i] = points.weights[1 + i];
}

}  // namespace detail

/// Returns the nearest points of two triangles. Differences of the coordinates must be finite in double.
SOFTCD_HD inline ClosestOnTriangles closest_points_of_triangles(const Vec3f (&a)[3], const Vec3f (&b)[3]) {
  const Vec3d a_wide[3] = {vec3_cast<double>(a[0]), vec3_cast<double>(a[1]), vec3_cast<double>(a[2])};
  const Vec3d b_wide[3] = {vec3_cast<double>(b[0]), vec3_cast<double>(b[1]), vec3_cast<double>(b[2])};
  ClosestOnTriangles result = detail::NearestOfFeatures(a_wide, b_wide).best();
  const CornerSides sides_of_a(a, 0, b);
  if (sides_of_a.are_on_one) return result;
  const CornerSides sides_of_b(b, 0, a);
  if (sides_of_b.are_on_one) return result;
  const int side_of_a = first_side_through(a, 0, sides_of_a, b);
  const int side_of_b = side_of_a < 3 ? 3 : first_side_through(b, 0, sides_of_b, a);
  if (side_of_a == 3 && side_of_b == 3) return result;
  // Triangles in one plane need no crossing: the nearest points of their features are common points.
  if (side_of_a < 3 && sides_of_a.crosses(side_of_a)) {
    detail::set_crossing(a_wide, side_of_a, b_wide, result.weights_a, result.weights_b);
  } else if (side_of_b < 3 && sides_of_b.crosses(side_of_b)) {
    detail::set_crossing(b_wide, side_of_b, a_wide, result.weights_b, result.weights_a);
  }
  result.squared_distance = 0.0;
  result.offset = detail::weighted(a_wide, result.weights_a) - detail::weighted(b_wide, result.weights_b);
  return result;
}

}  // namespace softcd
