#pragma once

#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "bodies/bounds.hpp"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

/// Returns whether the object stands still. Bullet's usual way to make a body of mass 0 kinematic leaves it static as
/// well.
inline bool is_standing(const btCollisionObject& object) {
  return object.isStaticObject() && !object.isKinematicObject();
}

/// Calls visit(shape, place) for the shape, or for all simple shapes of its compound in order, until one call returns
/// true. Returns whether one did. `place` is the shape's transform.
template <class Visit>
bool any_simple_shape(const btCollisionShape& shape, const btTransform& place, Visit&& visit) {
  if (!shape.isCompound()) return visit(shape, place);
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    if (any_simple_shape(*compound.getChildShape(i), place * compound.getChildTransform(i), visit)) return true;
  }
  return false;
}

/// The poses of a rigid shape at both ends of a step. In Bullet, kinematic objects are already at their end, all others
/// still at their start.
struct RigidPoses {
  btTransform t0, t1;
};
RigidPoses poses_of(const btCollisionObject& object, const btTransform& shape_in_object, btScalar time_step);

/// Returns a box, in a shape's coordinates, around `box` as the shape moves during the step and each of its vertices
/// moves straight.
Bounds box_in_shape(const Bounds& box, const RigidPoses& poses);

/// The triangles of a rigid shape, and its vertices at both ends of the step.
class RigidShape {
 public:
  /// Places the vertices. Returns false if they are there already.
  bool place(const RigidPoses& poses);

  const std::vector<btVector3>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(vertices_.size()); }
  const std::vector<Vec3d>& x_t0() const { return x_t0_; }
  const std::vector<Vec3d>& x_t1() const { return x_t1_; }

 protected:
  /// Removes everything but the last poses.
  void clear();

  std::vector<btVector3> vertices_;
  std::vector<Triangle> triangles_;

 private:
  RigidPoses placed_;
  std::vector<Vec3d> x_t0_, x_t1_;
};

/// Returns whether these are the same points, in the same order.
bool are_equal(const std::vector<btVector3>& a, const std::vector<btVector3>& b);

}  // namespace softcd::bullet
