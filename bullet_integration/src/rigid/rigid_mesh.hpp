#pragma once

#include <vector>

#include "rigid/rigid_placement.hpp"

class btConcaveShape;

namespace softcd::bullet {

/// The part of a rigid triangle mesh that soft bodies can touch, read anew in every step: meshes deform, are scaled, or
/// make way for others at the same address. Which part that is changes rarely.
class RigidMesh : public RigidShape {
 public:
  /// Boxes of all that may touch it, in the shape's coordinates. True when the triangles are no longer the same.
  bool read(const btConcaveShape& shape, const std::vector<RigidBox>& boxes);
  /// Whether all triangles that overlap this box have been read.
  bool covers(const RigidBox& box) const;

 private:
  void weld();

  std::vector<RigidBox> regions_;
  std::vector<btVector3> corners_;  ///< of the triangles in the regions, three each
};

}  // namespace softcd::bullet
