#pragma once

#include <cstddef>

#include "softcd/core/host_device.hpp"
#include "softcd/core/span.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/scalar.hpp"

/// Tests whether a triangle is near the convex hull of points, by the distance of the origin from the differences of
/// their points (Gilbert, Johnson and Keerthi 1988).
namespace softcd {
namespace detail {

/// Returns the side of the plane through the origin, a and b on which c lies; 0 where rounding could change it.
SOFTCD_HD inline int certain_side(Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d across = cross(a, b);
  const double determinant = dot(across, c);
  const Vec3d size = {magnitude(a.y * b.z) + magnitude(a.z * b.y), magnitude(a.z * b.x) + magnitude(a.x * b.z),
                      magnitude(a.x * b.y) + magnitude(a.y * b.x)};
  const double error = 0x1p-50 * (size.x * magnitude(c.x) + size.y * magnitude(c.y) + size.z * magnitude(c.z));
  return determinant > error ? 1 : (determinant < -error ? -1 : 0);
}

/// Up to three points, and the point of their hull that is nearest to the origin.
class NearestSimplex {
 public:
  SOFTCD_HD explicit NearestSimplex(Vec3d first)
      : x_{first, first, first}, direction_(first), squared_distance_(squared_norm(first)) {}

  SOFTCD_HD double squared_distance() const { return squared_distance_; }
  /// Returns the vector from the origin to the nearest point, or the normal where that point is the origin.
  SOFTCD_HD Vec3d direction() const { return direction_; }
  SOFTCD_HD bool has(Vec3d x) const {
    bool is_there = false;
    for (int i = 0; i < count_; ++i) is_there = is_there || x_[i] == x;
    return is_there;
  }

  /// Adds a point, and drops those that the nearest point does not lie between. The new point always stays, because it
  /// is further towards the origin than the others. So the nearest point is on a side with it, even where rounding
  /// hides that.
  SOFTCD_HD void add(Vec3d x) {
    if (count_ < 3) {
      keep_nearest({{x_[0], x_[count_ - 1], x}});
      return;
    }
    if (is_origin_inside(x)) {
      squared_distance_ = 0.0;
      return;
    }
    const Corners sides[3] = {{{x_[0], x_[1], x}}, {{x_[1], x_[2], x}}, {{x_[2], x_[0], x}}};
    int nearest = 0;
    double least = squared_distance_of(sides[0]);
    for (int side = 1; side < 3; ++side) {
      const double distance = squared_distance_of(sides[side]);
      if (!(distance < least)) continue;
      nearest = side;
      least = distance;
    }
    keep_nearest(sides[nearest]);
  }

 private:
  struct Corners {
    Vec3d x[3];
  };

  static SOFTCD_HD ClosestPoints<double> nearest_of(const Corners& corners) {
    return closest_points_vertex_triangle(Vec3d{0, 0, 0}, corners.x[0], corners.x[1], corners.x[2]);
  }
  static SOFTCD_HD double squared_of(const ClosestPoints<double>& points) {
    const double inverse = 1.0 / points.scale;
    return points.squared_distance * inverse * inverse;
  }
  static SOFTCD_HD double squared_distance_of(const Corners& corners) { return squared_of(nearest_of(corners)); }

  /// Returns whether the origin is inside, as far as that is certain.
  SOFTCD_HD bool is_origin_inside(Vec3d x) const {
    const int side = certain_side(x_[0], x_[1], x_[2]);
    return side != 0 && certain_side(x_[0], x, x_[1]) == side && certain_side(x_[1], x, x_[2]) == side &&
           certain_side(x_[2], x, x_[0]) == side;
  }

  SOFTCD_HD void keep_nearest(const Corners& corners) {
    const ClosestPoints<double> nearest = nearest_of(corners);
    squared_distance_ = squared_of(nearest);
    direction_ = (-1.0 / nearest.scale) * nearest.offset;
    count_ = 0;
    for (int i = 0; i < 2; ++i) {
      if (nearest.weights[1 + i] > 0.0 && !has(corners.x[i])) x_[count_++] = corners.x[i];
    }
    x_[count_++] = corners.x[2];
    if (count_ == 2) turn_across_edge();
    if (count_ == 3) turn_to_normal();
  }

  /// Removes the component along the edge, because its rounding error may exceed the distance.
  SOFTCD_HD void turn_across_edge() {
    const Vec3d edge = x_[1] - x_[0];
    const double along = dot(direction_, edge) / squared_norm(edge);
    direction_ = direction_ - along * edge;
  }

  /// Takes the triangle's normal as the direction, where the distance is too small to give one. The two shorter sides
  /// define it, because a sliver's longest side may be nearly parallel to another one.
  SOFTCD_HD void turn_to_normal() {
    const Vec3d sides[3] = {x_[1] - x_[0], x_[2] - x_[1], x_[0] - x_[2]};
    const double lengths[3] = {squared_norm(sides[0]), squared_norm(sides[1]), squared_norm(sides[2])};
    const int longest = lengths[0] >= lengths[1] && lengths[0] >= lengths[2] ? 0 : (lengths[1] >= lengths[2] ? 1 : 2);
    const Vec3d normal = cross(sides[longest == 2 ? 0 : longest + 1], sides[longest == 0 ? 2 : longest - 1]);
    const double away = dot(normal, x_[0]);
    if (away != 0.0) direction_ = away < 0.0 ? -normal : normal;
  }

  Vec3d x_[3];
  int count_ = 1;
  Vec3d direction_;
  double squared_distance_;
};

}  // namespace detail

/// Points relative to an origin.
struct PlacedPoints {
  Span<const Vec3d> in_world;
  Vec3d origin;

  SOFTCD_HD std::size_t size() const { return in_world.size(); }
  SOFTCD_HD Vec3d operator[](std::size_t i) const { return in_world[i] - origin; }
};

/// Returns whether some point of the triangle is within the distance of the convex hull of at least one point. The
/// hull's points may be collinear, coplanar, inside the hull or repeated. Returns false only where a plane separates
/// the two by more than the distance, as computed. A pair that is nearly that far apart may therefore count as near,
/// when no such plane is found in time.
SOFTCD_HD inline bool are_hull_and_triangle_within(const PlacedPoints& hull, const Vec3d (&t)[3],
                                                   double squared_distance) {
  // Far more rounds than these points need, unless rounding prevents convergence.
  constexpr int kMostRounds = 64;
  detail::NearestSimplex nearest(hull[0] - t[0]);
  for (int round = 0; round < kMostRounds; ++round) {
    if (nearest.squared_distance() <= squared_distance) return true;
    const Vec3d direction = nearest.direction();
    Vec3d foremost = hull[0];
    double least = dot(direction, foremost);
    for (std::size_t i = 1; i < hull.size(); ++i) {
      const Vec3d point = hull[i];
      const double along = dot(direction, point);
      if (!(along < least)) continue;
      least = along;
      foremost = point;
    }
    int corner = dot(direction, t[1]) > dot(direction, t[0]) ? 1 : 0;
    if (dot(direction, t[2]) > dot(direction, t[corner])) corner = 2;
    const Vec3d difference = foremost - t[corner];
    const double gap = dot(direction, difference);
    if (gap > 0.0 && gap * gap > squared_distance * squared_norm(direction)) return false;
    // No plane separates them further than this one.
    if (nearest.has(difference)) return true;
    nearest.add(difference);
  }
  return true;
}

}  // namespace softcd
