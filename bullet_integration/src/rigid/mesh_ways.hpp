#pragma once

#include <unordered_map>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "rigid/rigid_placement.hpp"

class btConcaveShape;
class btRigidBody;

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
/// keeps no more than their velocities.
///
/// Bullet knows no velocity of a kinematic body that sleeps, nor where the app sets the interpolation transform as
/// well. Such a body gets its velocity for the length of a step. Where it is further away than its own size it has
/// jumped instead, and nothing is between the two places.
class MeshWays {
 public:
  /// Before Bullet moves rigid objects in a step.
  void keep_starts(const btCollisionObjectArray& objects, btScalar time_step);
  /// Afterwards, once.
  std::vector<MeshWay> find(const btCollisionObjectArray& objects);

 private:
  struct Lent {
    btRigidBody* body;
    btVector3 linear, angular;  ///< its velocities before
  };

  btTransform start_of(const btCollisionObject& object, btScalar time_step) const;
  void lend_velocity(btCollisionObject& object, const btTransform& start, btScalar time_step);
  void take_velocities_back(const btCollisionObjectArray& objects);

  struct Track {
    btTransform start;  ///< of this step
    btTransform last;   ///< where the object was seen last
  };
  std::unordered_map<const btCollisionObject*, Track> tracks_;  ///< of objects that have meshes and may move
  std::vector<Lent> lent_;                                      ///< in this step
};

}  // namespace softcd::bullet
