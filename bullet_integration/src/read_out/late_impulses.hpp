#pragma once

#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletSoftBody/btSoftBody.h"
#include "read_out/contact_read_out.hpp"

namespace softcd::bullet {

/// What ends a step of Bullet's classic worlds where soft bodies and convex shapes have met on their way.
/// Bullet moves rigid bodies first and solves soft bodies then, so that what stops a rigid body does so from the next
/// step on, when it is through; and solves contacts before links, which pull nodes back through what they were pushed
/// out of. Here contacts are solved once more, last of all, and rigid bodies go back to where their new velocities
/// would have led.
class LateImpulses {
 public:
  void clear();
  /// Throws std::bad_alloc. Each may be told several times.
  void add(btSoftBody& soft, const btCollisionObject& object);
  /// For a body with contacts on rigid meshes: solves them once more where the links have pulled a node deeper than the
  /// body's margin. Throws std::bad_alloc.
  void add_on_mesh(btSoftBody& soft);

  /// When rigid bodies have been moved, before soft bodies are solved.
  void keep_velocities();
  /// Afterwards, once. What is not among the world's objects any more is left alone, and so is what touches it. Adds
  /// what contacts give to `impulses`, unless that is null, where those of the solver before are known.
  void answer(const btCollisionObjectArray& objects, btScalar time_step, ContactImpulses* impulses);

 private:
  struct Rigid {
    btRigidBody* body;
    btVector3 linear, angular;
  };
  std::vector<Rigid> rigid_;
  std::vector<btSoftBody*> soft_;
  std::vector<btSoftBody*> on_meshes_;  ///< solved once more only where they are deep
  std::vector<btVector3> before_;       ///< reserved where a body is added, so that answer() needs no memory
};

}  // namespace softcd::bullet
