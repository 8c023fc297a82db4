#pragma once

#include <vector>

#include "bodies/rigid_placement.hpp"

class btConcaveShape;

namespace softcd::bullet {

/// The part of a rigid triangle mesh that soft bodies can touch. It is read in every step, because meshes deform, are
/// scaled, or are replaced at the same address. The part itself rarely changes.
class RigidMesh : public RigidShape {
 public:
  /// Reads the triangles near `boxes`, which contain all bodies that may touch the mesh, in the shape's coordinates.
  /// Returns whether the triangles have changed.
  bool read(const btConcaveShape& shape, const std::vector<Bounds>& boxes);
  /// Reads all triangles, until the next read() with boxes.
  bool read_whole(const btConcaveShape& shape);
  /// Returns whether all triangles that overlap this box have been read.
  bool covers(const Bounds& box) const;

 private:
  bool read_regions(const btConcaveShape& shape);
  void weld();

  std::vector<Bounds> regions_;
  bool is_whole_ = false;
  std::vector<btVector3> corners_;  ///< three for each triangle in the regions
};

}  // namespace softcd::bullet
