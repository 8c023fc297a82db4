#pragma once

#include <unordered_map>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "bodies/body_key.hpp"
#include "bodies/rigid_placement.hpp"

class btConcaveShape;
class btRigidBody;

namespace softcd::bullet {

/// A rigid triangle mesh and its poses at both ends of a step.
struct MeshWay {
  btCollisionObject* object;
  const btConcaveShape* shape;
  int child;  ///< number of the mesh among the object's
  RigidPoses poses;
  Bounds box;                ///< around both poses
  btTransform object_start;  ///< place of the object when the step began
};

/// The paths of a world's rigid triangle meshes in a step. Each path begins where the last one ended, so that paths
/// have no gaps between them. This class keeps these ends, because Bullet moves kinematic objects in the first step of
/// a frame and keeps only their velocities.
///
/// Bullet knows no velocity of a kinematic body that sleeps, or whose interpolation transform the app sets as well.
/// Such a body gets its velocity for the length of a step. If it has moved by more than its own size, it has jumped
/// instead, and has no path. Owned by RigidObstacles.
class MeshWays {
 public:
  /// Saves where the meshes are. Call it before Bullet moves rigid objects in a step.
  void keep_starts(const btCollisionObjectArray& objects, btScalar time_step);
  /// Returns the meshes with their paths. Call it once, after Bullet has moved the objects.
  std::vector<MeshWay> find(const btCollisionObjectArray& objects);

 private:
  struct Lent {
    btRigidBody* body;
    btVector3 linear, angular;  ///< its own velocities, to be restored
  };

  btTransform start_of(const btCollisionObject& object, btScalar time_step) const;
  void lend_velocity(btCollisionObject& object, const btTransform& start, btScalar time_step);
  void take_velocities_back(const btCollisionObjectArray& objects);

  struct Track {
    btTransform start;  ///< of this step
    btTransform last;   ///< the object's last known place
  };
  std::unordered_map<BodyKey, Track, BodyKeyHash> tracks_;  ///< of objects that have meshes and may move
  std::vector<Lent> lent_;                                  ///< in this step
};

}  // namespace softcd::bullet
