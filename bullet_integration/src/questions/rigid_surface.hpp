#pragma once

#include <vector>

#include "rigid/convex_core.hpp"
#include "rigid/rigid_mesh.hpp"

namespace softcd::bullet {

/// One of the shapes that an object's shape is made of, as triangles where it is now.
class RigidSurface {
 public:
  /// How deep a point is in a convex core, and under which of its faces.
  struct Depth {
    bool is_inside = false;
    double depth = 0;
    Vec3d normal{0, 0, 0};  ///< out of the core
  };

  RigidSurface(const btConvexShape& shape, const btTransform& place);
  /// Those of its triangles that a box in the world's coordinates overlaps.
  RigidSurface(const btConcaveShape& shape, const btTransform& place, const RigidBox& box);

  const std::vector<Triangle>& triangles() const { return shape().triangles(); }
  const std::vector<Vec3d>& x() const { return shape().x_t1(); }
  btScalar margin() const { return margin_; }
  /// Whether these vertices are an edge's, not a diagonal's of one of a convex core's faces.
  bool is_edge(std::uint32_t low, std::uint32_t high) const { return !is_convex_ || core_.is_edge(low, high); }
  Depth depth_of(Vec3d point) const;

 private:
  const RigidShape& shape() const { return is_convex_ ? static_cast<const RigidShape&>(core_) : mesh_; }

  bool is_convex_;
  btScalar margin_;
  ConvexCore core_;
  RigidMesh mesh_;
};

/// Of all that has triangles in an object's shape.
std::vector<RigidSurface> rigid_surfaces(const btCollisionObject& object, const RigidBox& box);

}  // namespace softcd::bullet
