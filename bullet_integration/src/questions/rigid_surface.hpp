#pragma once

#include <vector>

#include "bodies/convex_core.hpp"
#include "bodies/rigid_mesh.hpp"

namespace softcd::bullet {

/// A simple shape of an object, as triangles at its present place.
class RigidSurface {
 public:
  /// The depth of a point in a convex core, and the normal of the nearest face.
  struct Depth {
    bool is_inside = false;
    double depth = 0;
    Vec3d normal{0, 0, 0};  ///< out of the core
  };

  RigidSurface(const btConvexShape& shape, const btTransform& place);
  /// Reads the triangles that `box`, in the world's coordinates, overlaps.
  RigidSurface(const btConcaveShape& shape, const btTransform& place, const Bounds& box);

  const std::vector<Triangle>& triangles() const { return shape().triangles(); }
  const std::vector<Vec3d>& x() const { return shape().x_t1(); }
  btScalar margin() const { return margin_; }
  /// Returns whether these vertices are joined by an edge, not by a diagonal of a face of a convex core.
  bool is_edge(std::uint32_t low, std::uint32_t high) const { return !is_convex_ || core_.is_edge(low, high); }
  Depth depth_of(Vec3d point) const;

 private:
  const RigidShape& shape() const { return is_convex_ ? static_cast<const RigidShape&>(core_) : mesh_; }

  bool is_convex_;
  btScalar margin_;
  ConvexCore core_;
  RigidMesh mesh_;
};

/// Returns the surfaces of all simple shapes of the object that have triangles.
std::vector<RigidSurface> rigid_surfaces(const btCollisionObject& object, const Bounds& box);

}  // namespace softcd::bullet
