#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btConvexShape.h"
#include "bodies/rigid_placement.hpp"

namespace softcd::bullet {

/// A convex shape without its margin. In Bullet a shape is the set of all points within its margin of such a core: of a
/// point for a sphere, a segment for a capsule, a smaller box for a box. Cores of polyhedra, spheres and capsules are
/// exact here. Those of other shapes are inscribed: circles of cylinders and cones have kCircleCorners corners, other
/// round shapes kCircleCorners / 2 corners from pole to pole.
class ConvexCore : public RigidShape {
 public:
  static constexpr int kCircleCorners = 32;

  /// Reads the shape, which may have been scaled, changed or replaced. Returns whether the triangles have changed.
  bool read(const btConvexShape& shape);
  /// Returns whether these vertices are joined by an edge of the polyhedron, not by a diagonal of one of its faces.
  bool is_edge(std::uint32_t low, std::uint32_t high) const;
  /// Returns whether no point of the core is farther than `point` along `normal` at this time of the step. Otherwise
  /// the object cannot be touched there from that side. Allows a hundredth of the distance from `point`, and the last
  /// digits of single precision, which contacts' weights and times have, as rounding. `point` may itself be a vertex.
  bool is_farthest(const btVector3& point, const btVector3& normal, double time) const;
  /// The depth of a point in a core, and the normal of the nearest face.
  struct Depth {
    bool is_inside = false;
    double depth = 0;
    Vec3d normal{0, 0, 0};  ///< out of the core
  };
  /// Returns the depth at the start of the step.
  Depth depth_of(Vec3d point) const;
  /// Returns whether the point is inside the core at the start of the step, and nearer to the core's end against
  /// `normal` than to the one along it.
  bool is_pierced(const btVector3& point, const btVector3& normal) const;

 private:
  void build();

  std::vector<btVector3> points_;                               ///< as read from the shape
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;  ///< lower vertex first, ascending
};

}  // namespace softcd::bullet
