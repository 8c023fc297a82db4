#pragma once

#include <vector>

#include "mesh_pairs.hpp"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

/// Where a rigid mesh is at both ends of a step. Bullet's objects that somebody else moves (kinematic ones) are already
/// where they will be at the end, all others are where they were at the start.
struct MeshPoses {
  btTransform t0, t1;
};
MeshPoses poses_of(const MeshPair& pair, btScalar time_step);

/// The part of a rigid triangle mesh that soft bodies can touch, read anew in every step: meshes deform, are scaled, or
/// make way for others at the same address. Which part that is changes rarely.
class RigidMesh {
 public:
  struct Box {
    btVector3 low, high;
  };

  /// Boxes of all that may touch it, in the shape's coordinates. True when the triangles are no longer the same.
  bool read(const btConcaveShape& shape, const std::vector<Box>& boxes);
  /// Where its vertices are at both ends of the step. False when they have not changed.
  bool place(const MeshPoses& poses);

  const std::vector<Triangle>& triangles() const { return triangles_; }
  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(vertices_.size()); }
  const std::vector<Vec3d>& x_t0() const { return x_t0_; }
  const std::vector<Vec3d>& x_t1() const { return x_t1_; }

 private:
  void weld();

  std::vector<Box> regions_;
  std::vector<btVector3> corners_;  ///< of the triangles in the regions, three each
  std::vector<btVector3> vertices_;
  std::vector<Triangle> triangles_;
  MeshPoses placed_;
  std::vector<Vec3d> x_t0_, x_t1_;
};

}  // namespace softcd::bullet
