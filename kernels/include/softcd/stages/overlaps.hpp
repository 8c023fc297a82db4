#pragma once

#include <cfloat>
#include <cstddef>
#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/hull_triangle.hpp"
#include "softcd/math/ray_triangle.hpp"
#include "softcd/math/segment_triangle.hpp"
#include "softcd/math/triangle_box.hpp"
#include "softcd/stages/closest_points.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd {

/// Visits leaves whose boxes are near, and finds triangles that `Shape` overlaps. It has may_overlap(box) and
/// overlaps(leaf).
template <class Shape, class Sink>
class OverlapVisitor {
 public:
  using Key = bool;

  SOFTCD_HD OverlapVisitor(const ProbedSceneView& scene, const Shape& shape, Sink& sink)
      : scene_(scene), shape_(shape), sink_(sink) {}

  SOFTCD_HD bool enters(const Box& box, bool& key) const {
    key = true;
    return shape_.may_overlap(box);
  }
  SOFTCD_HD bool still_enters(bool /*key*/) const { return true; }
  SOFTCD_HD void visit(const BvhLeaf& leaf, std::uint32_t /*place*/) {
    if (!scene_.is_asked(leaf) || !shape_.overlaps(leaf)) return;
    const ProbedBody& body = scene_.bodies[leaf.body];
    sink_.add([&] { return TriangleOverlap{{body.id}, leaf.triangle - body.first_triangle}; });
  }

 private:
  const ProbedSceneView& scene_;
  const Shape& shape_;
  Sink& sink_;
};

/// A ball relative to the scene's origin.
class SphereShape {
 public:
  SOFTCD_HD SphereShape(const ProbeSphere& sphere, const ProbedSceneView& scene)
      : centre_(sphere.centre - scene.origin),
        squared_radius_(sphere.radius * sphere.radius),
        is_usable_(softcd::is_usable(centre_) && sphere.radius >= 0.0),
        reach_(reach_of(squared_radius_, scene)) {}

  SOFTCD_HD bool is_usable() const { return is_usable_; }
  SOFTCD_HD bool may_overlap(const Box& box) const { return squared_distance(box, centre_) <= reach_; }
  SOFTCD_HD bool overlaps(const BvhLeaf& leaf) const {
    return nearest_on(leaf, 0, centre_).squared_distance <= squared_radius_;
  }

 private:
  Vec3d centre_;
  double squared_radius_;
  bool is_usable_;
  double reach_;
};

/// A capsule relative to the scene's origin. Boxes of triangles grow by its radius, and are compared with its segment.
class CapsuleShape {
 public:
  SOFTCD_HD CapsuleShape(const ProbeCapsule& capsule, const ProbedSceneView& scene)
      : from_(capsule.from - scene.origin),
        to_(capsule.to - scene.origin),
        squared_radius_(capsule.radius * capsule.radius),
        is_usable_(softcd::is_usable(from_) && softcd::is_usable(to_) && capsule.radius >= 0.0) {
    // Along any axis, the products of a segment and a box are off by less than that.
    const double rounding = 0x1p-48 * (max_norm(from_) + max_norm(to_) + max_norm(scene.centre) + scene.extent);
    const double reach = square_root(reach_of(squared_radius_, scene)) + rounding;
    reach_ = {reach, reach, reach};
  }

  SOFTCD_HD bool is_usable() const { return is_usable_; }
  SOFTCD_HD bool may_overlap(const Box& box) const {
    const Vec3d lo = vec3_cast<double>(box.lo);
    const Vec3d hi = vec3_cast<double>(box.hi);
    const Vec3d centre = 0.5 * (lo + hi);
    const Vec3d half = 0.5 * (hi - lo) + reach_;
    const Vec3d segment[3] = {from_ - centre, to_ - centre, to_ - centre};
    for (int axis = 0; axis < 3; ++axis) {
      if (smaller(segment[0][axis], segment[1][axis]) > half[axis]) return false;
      if (larger(segment[0][axis], segment[1][axis]) < -half[axis]) return false;
    }
    return !are_separate_across(segment, half);
  }
  SOFTCD_HD bool overlaps(const BvhLeaf& leaf) const {
    const Vec3d t[3] = {vec3_cast<double>(leaf.x[0]), vec3_cast<double>(leaf.x[1]), vec3_cast<double>(leaf.x[2])};
    return are_segment_and_triangle_within(from_, to_, t, squared_radius_);
  }

 private:
  Vec3d from_, to_;
  double squared_radius_;
  bool is_usable_;
  Vec3d reach_{0, 0, 0};
};

/// A box relative to the scene's origin.
class BoxShape {
 public:
  SOFTCD_HD BoxShape(const ProbeBox& box, const ProbedSceneView& scene)
      : lo_(within_reach(box.lo - scene.origin)),
        hi_(within_reach(box.hi - scene.origin)),
        is_usable_(box.lo.x <= box.hi.x && box.lo.y <= box.hi.y && box.lo.z <= box.hi.z) {}

  SOFTCD_HD bool is_usable() const { return is_usable_; }
  SOFTCD_HD bool may_overlap(const Box& box) const {
    const Vec3d lo = vec3_cast<double>(box.lo);
    const Vec3d hi = vec3_cast<double>(box.hi);
    return lo.x <= hi_.x && lo_.x <= hi.x && lo.y <= hi_.y && lo_.y <= hi.y && lo.z <= hi_.z && lo_.z <= hi.z;
  }
  SOFTCD_HD bool overlaps(const BvhLeaf& leaf) const {
    const Vec3d centre = 0.5 * (lo_ + hi_);
    const Vec3d v[3] = {vec3_cast<double>(leaf.x[0]) - centre, vec3_cast<double>(leaf.x[1]) - centre,
                        vec3_cast<double>(leaf.x[2]) - centre};
    return may_overlap(box_of(leaf.x)) && !are_separate_across(v, 0.5 * (hi_ - lo_));
  }

 private:
  /// No triangles are beyond.
  static SOFTCD_HD double within_reach(double x) {
    return smaller(larger(x, -2.0 * kLargestCoordinate), 2.0 * kLargestCoordinate);
  }
  static SOFTCD_HD Vec3d within_reach(Vec3d p) { return {within_reach(p.x), within_reach(p.y), within_reach(p.z)}; }

  Vec3d lo_, hi_;
  bool is_usable_;
};

/// A rotated box relative to the scene's origin. Compares boxes of triangles with the box around it, and triangles in
/// its own axes.
class OrientedBoxShape {
 public:
  SOFTCD_HD OrientedBoxShape(const ProbeOrientedBox& box, const ProbedSceneView& scene)
      : box_(box), centre_(box.centre - scene.origin) {
    is_usable_ = softcd::is_usable(centre_) && box.half.x >= 0.0 && box.half.y >= 0.0 && box.half.z >= 0.0;
    for (const Vec3d& axis : box.axes) is_usable_ &= softcd::is_usable(axis);
    box_.half = {smaller(box.half.x, kFurthest), smaller(box.half.y, kFurthest), smaller(box.half.z, kFurthest)};
    for (int axis = 0; axis < 3; ++axis) {
      const double reach = box_.half.x * magnitude(box.axes[0][axis]) + box_.half.y * magnitude(box.axes[1][axis]) +
                           box_.half.z * magnitude(box.axes[2][axis]);
      // Covers axes that are not quite at right angles, and the roundings of triangles.
      reach_[axis] = reach + kRounding * (reach + magnitude(centre_[axis]));
    }
  }

  SOFTCD_HD bool is_usable() const { return is_usable_; }
  SOFTCD_HD bool may_overlap(const Box& box) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (static_cast<double>(box.lo[axis]) - centre_[axis] > reach_[axis]) return false;
      if (centre_[axis] - static_cast<double>(box.hi[axis]) > reach_[axis]) return false;
    }
    return true;
  }
  SOFTCD_HD bool overlaps(const BvhLeaf& leaf) const {
    Vec3d v[3];
    for (int corner = 0; corner < 3; ++corner) {
      const Vec3d x = vec3_cast<double>(leaf.x[corner]) - centre_;
      v[corner] = {dot(box_.axes[0], x), dot(box_.axes[1], x), dot(box_.axes[2], x)};
    }
    for (int axis = 0; axis < 3; ++axis) {
      const double lowest = smaller(smaller(v[0][axis], v[1][axis]), v[2][axis]);
      const double highest = larger(larger(v[0][axis], v[1][axis]), v[2][axis]);
      if (lowest > box_.half[axis] || highest < -box_.half[axis]) return false;
    }
    return !are_separate_across(v, box_.half);
  }

 private:
  static constexpr double kRounding = 1e-14;
  /// No two points of a scene are further apart along an axis.
  static constexpr double kFurthest = 4.0 * kLargestCoordinate;

  ProbeOrientedBox box_;
  Vec3d centre_;
  double reach_[3] = {};
  bool is_usable_ = false;
};

/// A convex hull relative to the scene's origin. Compares boxes of triangles with the box around it.
class HullShape {
 public:
  SOFTCD_HD HullShape(const ProbeHull& hull, const ProbedSceneView& scene)
      : points_{hull.points, scene.origin},
        squared_radius_(hull.radius * hull.radius),
        is_usable_(!hull.points.empty() && hull.radius >= 0.0) {
    const double reach = square_root(reach_of(squared_radius_, scene));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3d p = points_[i];
      is_usable_ = is_usable_ && softcd::is_usable(p);
      for (int axis = 0; axis < 3; ++axis) {
        lo_[axis] = smaller(p[axis] - reach, lo_[axis]);
        hi_[axis] = larger(p[axis] + reach, hi_[axis]);
      }
    }
  }

  SOFTCD_HD bool is_usable() const { return is_usable_; }
  SOFTCD_HD bool may_overlap(const Box& box) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (static_cast<double>(box.lo[axis]) > hi_[axis] || static_cast<double>(box.hi[axis]) < lo_[axis]) return false;
    }
    return true;
  }
  SOFTCD_HD bool overlaps(const BvhLeaf& leaf) const {
    const Vec3d t[3] = {vec3_cast<double>(leaf.x[0]), vec3_cast<double>(leaf.x[1]), vec3_cast<double>(leaf.x[2])};
    return are_hull_and_triangle_within(points_, t, squared_radius_);
  }

 private:
  PlacedPoints points_;
  double squared_radius_;
  bool is_usable_;
  double lo_[3] = {DBL_MAX, DBL_MAX, DBL_MAX};
  double hi_[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
};

/// Lists the triangles that each shape overlaps, by bodies and indices. questions[i] describes shape i.
template <class Questions, class Shape>
struct ListOverlaps {
  using Answer = TriangleOverlap;

  ProbedSceneView scene;
  Questions questions;

  template <class Sink>
  SOFTCD_HD void list(std::uint32_t i, Sink& sink) const {
    const Shape shape(questions[i], scene);
    if (!shape.is_usable()) return;
    OverlapVisitor<Shape, Sink> visitor(scene, shape, sink);
    visit_leaves(scene.bvh, visitor);
  }

  static SOFTCD_HD bool is_before(const TriangleOverlap& a, const TriangleOverlap& b) {
    return a.body.value != b.body.value ? a.body.value < b.body.value : a.triangle < b.triangle;
  }
};

}  // namespace softcd
