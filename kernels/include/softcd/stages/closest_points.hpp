#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/pseudo_normal.hpp"
#include "softcd/math/ray_triangle.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd {

SOFTCD_HD inline double beyond(double lo, double hi, double x) {
  return larger(larger(lo - x, x - hi), 0.0);
}

SOFTCD_HD inline double squared_distance(const Box& box, Vec3d p) {
  const Vec3d offset{beyond(static_cast<double>(box.lo.x), static_cast<double>(box.hi.x), p.x),
                     beyond(static_cast<double>(box.lo.y), static_cast<double>(box.hi.y), p.y),
                     beyond(static_cast<double>(box.lo.z), static_cast<double>(box.hi.z), p.z)};
  return squared_norm(offset);
}

/// The nearest point of a leaf's triangle.
struct NearestOnLeaf {
  std::uint32_t place;
  std::uint32_t triangle;
  double squared_distance;
  double weights[3];
  Vec3d offset;  ///< the probe's point minus this one

  SOFTCD_HD bool is_before(const NearestOnLeaf& other) const {
    return squared_distance < other.squared_distance ||
           (squared_distance == other.squared_distance && triangle < other.triangle);
  }
};

SOFTCD_HD inline NearestOnLeaf nearest_on(const BvhLeaf& leaf, std::uint32_t place, Vec3d p) {
  const ClosestPoints<double> points = closest_points_vertex_triangle(
      p, vec3_cast<double>(leaf.x[0]), vec3_cast<double>(leaf.x[1]), vec3_cast<double>(leaf.x[2]));
  const double inverse = 1.0 / points.scale;
  return {place,
          leaf.triangle,
          points.squared_distance * inverse * inverse,
          {points.weights[1], points.weights[2], points.weights[3]},
          inverse * points.offset};
}

/// Returns a bound on the squared distance of boxes whose triangles are computed to be within `squared_distance`.
/// Rounding moves a distance d by at most 2^-50 (d + extent), its square by less than 2^-39 of it and 2^-57 of the
/// extent's.
SOFTCD_HD inline double reach_of(double squared_distance, const ProbedSceneView& scene) {
  return squared_distance * (1.0 + 0x1p-38) + 0x1p-57 * scene.extent * scene.extent;
}

/// Finds the nearest triangle. Skips a box only if it is further away by more than rounding. So the choice among
/// equally distant triangles does not depend on the order of visits.
class NearestVisitor {
 public:
  using Key = double;

  SOFTCD_HD NearestVisitor(const ProbedSceneView& scene, Vec3d p, double max_distance) : scene_(scene), p_(p) {
    best_.place = kNoIndex;
    best_.triangle = kNoIndex;
    best_.squared_distance = max_distance * max_distance;
    reach_ = reach_of(best_.squared_distance, scene);
  }

  SOFTCD_HD bool enters(const Box& box, double& key) const {
    key = squared_distance(box, p_);
    return still_enters(key);
  }
  SOFTCD_HD bool still_enters(double key) const { return key <= reach_; }
  SOFTCD_HD void visit(const BvhLeaf& leaf, std::uint32_t place) {
    if (!scene_.is_asked(leaf)) return;
    const NearestOnLeaf nearest = nearest_on(leaf, place, p_);
    if (!nearest.is_before(best_)) return;
    best_ = nearest;
    reach_ = reach_of(best_.squared_distance, scene_);
  }

  /// Its place is kNoIndex if there is none.
  SOFTCD_HD const NearestOnLeaf& best() const { return best_; }

 private:
  const ProbedSceneView& scene_;
  Vec3d p_;
  NearestOnLeaf best_;
  double reach_;
};

/// Sums the angle-weighted normals of a vertex, or the normals of an edge's triangles. Finds the feature's triangles at
/// its first vertex.
class FeatureNormalVisitor {
 public:
  using Key = bool;

  /// `second` is kNoIndex for a vertex.
  SOFTCD_HD FeatureNormalVisitor(const ProbedSceneView& scene, Vec3f x, std::uint32_t first, std::uint32_t second)
      : scene_(scene), box_(box_of(x)), first_(first), second_(second) {}

  SOFTCD_HD bool enters(const Box& box, bool& key) const {
    key = true;
    return overlap(box, box_);
  }
  SOFTCD_HD bool still_enters(bool /*key*/) const { return true; }
  SOFTCD_HD void visit(const BvhLeaf& leaf, std::uint32_t /*place*/) {
    if (leaf.triangle == kNoIndex) return;
    const Triangle triangle = scene_.triangles[leaf.triangle];
    if (!has_vertex(triangle, first_)) return;
    const Vec3d x[3] = {vec3_cast<double>(leaf.x[0]), vec3_cast<double>(leaf.x[1]), vec3_cast<double>(leaf.x[2])};
    if (second_ != kNoIndex) {
      if (has_vertex(triangle, second_)) normal_ = normal_ + triangle_normal(x);
      return;
    }
    const int corner = triangle.v[0] == first_ ? 0 : (triangle.v[1] == first_ ? 1 : 2);
    const Vec3d here = x[corner];
    const Vec3d next = x[corner == 2 ? 0 : corner + 1];
    const Vec3d last = x[corner == 0 ? 2 : corner - 1];
    normal_ = normal_ + angle_between(next - here, last - here) * triangle_normal(x);
  }

  SOFTCD_HD Vec3d normal() const { return normal_; }

 private:
  const ProbedSceneView& scene_;
  Box box_;
  std::uint32_t first_, second_;
  Vec3d normal_{0, 0, 0};
};

/// Returns the normal of the triangle's feature that the point is on. Weights are 0 exactly for corners that the
/// feature lacks.
SOFTCD_HD inline Vec3d feature_normal(const ProbedSceneView& scene, const BvhLeaf& leaf, const double (&weights)[3]) {
  int corners[3] = {0, 0, 0};
  int count = 0;
  for (int corner = 0; corner < 3; ++corner) {
    if (weights[corner] > 0.0) corners[count++] = corner;
  }
  if (count == 3) {
    const Vec3d x[3] = {vec3_cast<double>(leaf.x[0]), vec3_cast<double>(leaf.x[1]), vec3_cast<double>(leaf.x[2])};
    return triangle_normal(x);
  }
  const Triangle triangle = scene.triangles[leaf.triangle];
  const std::uint32_t second = count == 2 ? triangle.v[corners[1]] : kNoIndex;
  FeatureNormalVisitor visitor(scene, leaf.x[corners[0]], triangle.v[corners[0]], second);
  visit_leaves(scene.bvh, visitor);
  return visitor.normal();
}

struct FindClosestPoint {
  ProbedSceneView scene;
  const ProbePoint* points;
  ClosestPoint* closest;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const Vec3d p = points[i].point - scene.origin;
    const double max_distance = points[i].max_distance;
    ClosestPoint result;
    if (is_usable(p) && max_distance >= 0.0) {
      NearestVisitor visitor(scene, p, max_distance);
      visit_leaves(scene.bvh, visitor);
      if (visitor.best().place != kNoIndex) describe(visitor.best(), points[i].point, result);
    }
    closest[i] = result;
  }

 private:
  SOFTCD_HD void describe(const NearestOnLeaf& nearest, Vec3d p, ClosestPoint& result) const {
    const BvhLeaf& leaf = scene.bvh.leaves[nearest.place];
    const ProbedBody& body = scene.bodies[leaf.body];
    result.body = {body.id};
    result.triangle = leaf.triangle - body.first_triangle;
    result.position = p - nearest.offset;
    result.distance = length(nearest.offset);
    for (int corner = 0; corner < 3; ++corner) result.weights[corner] = static_cast<float>(nearest.weights[corner]);
    if (!body.is_closed || !(result.distance > 0.0)) return;
    const double along = dot(nearest.offset, feature_normal(scene, leaf, nearest.weights));
    result.side = along > 0.0 ? 1 : (along < 0.0 ? -1 : 0);
  }
};

}  // namespace softcd
