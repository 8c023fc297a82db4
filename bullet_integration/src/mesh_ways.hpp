#pragma once

#include <unordered_map>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "rigid_placement.hpp"

class btConcaveShape;

namespace softcd::bullet {

/// A rigid triangle mesh, and where it is at both ends of a step.
struct MeshWay {
  btCollisionObject* object;
  const btConcaveShape* shape;
  int child;  ///< which of the object's meshes
  RigidPoses poses;
  RigidBox box;  ///< around both
};

/// The ways of a world's rigid triangle meshes when Bullet has moved them. A step begins where the one before has
/// ended, so that nothing is between two ways: Bullet moves kinematic objects in the first of a frame's steps, and
/// keeps no more than their velocities. Those of static objects, and of kinematic ones without a velocity, are where
/// they are.
class MeshWays {
 public:
  /// Before Bullet moves rigid objects in a step.
  void keep_starts(const btCollisionObjectArray& objects, btScalar time_step);
  /// Afterwards, once.
  std::vector<MeshWay> find(const btCollisionObjectArray& objects);

 private:
  btTransform start_of(const btCollisionObject& object, btScalar time_step) const;

  std::unordered_map<const btCollisionObject*, btTransform> starts_;  ///< of what moves and has meshes
  std::unordered_map<const btCollisionObject*, btTransform> last_;    ///< where they were seen last
};

}  // namespace softcd::bullet
