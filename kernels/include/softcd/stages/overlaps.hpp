#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/ray_triangle.hpp"
#include "softcd/math/triangle_box.hpp"
#include "softcd/stages/closest_points.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd {

/// Leaves whose boxes are near, and triangles that `Shape` overlaps: it has may_overlap(box) and overlaps(leaf).
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
  SOFTCD_HD SphereShape(const QuerySphere& sphere, const ProbedSceneView& scene)
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

/// A box relative to the scene's origin.
class BoxShape {
 public:
  SOFTCD_HD BoxShape(const QueryBox& box, const ProbedSceneView& scene)
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
    return may_overlap(box_of(leaf.x)) && !are_separate_across(leaf.x, lo_, hi_);
  }

 private:
  /// Beyond, there are no triangles.
  static SOFTCD_HD double within_reach(double x) {
    return smaller(larger(x, -2.0 * kLargestCoordinate), 2.0 * kLargestCoordinate);
  }
  static SOFTCD_HD Vec3d within_reach(Vec3d p) { return {within_reach(p.x), within_reach(p.y), within_reach(p.z)}; }

  Vec3d lo_, hi_;
  bool is_usable_;
};

/// The triangles that each shape overlaps, by bodies and indices.
template <class Question, class Shape>
struct ListOverlaps {
  using Answer = TriangleOverlap;

  ProbedSceneView scene;
  const Question* questions;

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
