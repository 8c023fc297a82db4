#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btConvexShape.h"
#include "rigid/rigid_placement.hpp"

namespace softcd::bullet {

/// A convex shape without its margin. Bullet takes a shape for all that is within its margin of such a core: for a
/// sphere of one point, for a capsule of a segment, for a box of a smaller one. Cores of polyhedra, spheres and
/// capsules are exact here. Those of cylinders and cones are inscribed, with circles of kCircleCorners corners; what is
/// curved in another way is inscribed, too, with kCircleCorners / 2 corners from pole to pole.
class ConvexCore : public RigidShape {
 public:
  static constexpr int kCircleCorners = 32;

  /// Reads the shape, which may have been scaled, changed, or made way for another. True when the triangles are no
  /// longer the same.
  bool read(const btConvexShape& shape);
  /// Whether these vertices are an edge's of the polyhedron, not a diagonal's of one of its faces.
  bool is_edge(std::uint32_t low, std::uint32_t high) const;
  /// Whether none of it is further than `point` along `normal`, at that part of the step: an object cannot be touched
  /// from there else. What is off by a hundredth of its distance from the point counts as rounding, and so do the last
  /// digits of single precision, which contacts' weights and times have: the point may itself be one of its vertices.
  bool is_farthest(const btVector3& point, const btVector3& normal, double time) const;
  /// Where the step begins: whether the point is in it, nearer to where it ends against `normal` than to where it ends
  /// along it.
  bool is_pierced(const btVector3& point, const btVector3& normal) const;

 private:
  void build();

  std::vector<btVector3> points_;                               ///< as the shape gave them
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;  ///< lower vertex first, ascending
};

}  // namespace softcd::bullet
