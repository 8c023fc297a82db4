#pragma once

#include <vector>

#include "rigid/rigid_placement.hpp"

class btConcaveShape;

namespace softcd::bullet {

/// The part of a rigid triangle mesh that soft bodies can touch, read anew in every step: meshes deform, are scaled, or
/// make way for others at the same address. Which part that is changes rarely.
class RigidMesh {
 public:
  /// Boxes of all that may touch it, in the shape's coordinates. True when the triangles are no longer the same.
  bool read(const btConcaveShape& shape, const std::vector<RigidBox>& boxes);
  /// Whether all triangles that overlap this box have been read.
  bool covers(const RigidBox& box) const;
  /// Where its vertices are at both ends of the step. False when they have not changed.
  bool place(const RigidPoses& poses) { return placement_.place(vertices_, poses); }

  const std::vector<Triangle>& triangles() const { return triangles_; }
  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(vertices_.size()); }
  const std::vector<Vec3d>& x_t0() const { return placement_.x_t0(); }
  const std::vector<Vec3d>& x_t1() const { return placement_.x_t1(); }

 private:
  void weld();

  std::vector<RigidBox> regions_;
  std::vector<btVector3> corners_;  ///< of the triangles in the regions, three each
  std::vector<btVector3> vertices_;
  std::vector<Triangle> triangles_;
  RigidPlacement placement_;
};

}  // namespace softcd::bullet
