#pragma once

#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletSoftBody/btSoftBody.h"
#include "read_out/contact_read_out.hpp"

namespace softcd::bullet {

/// Solves contacts once more at the end of a step in Bullet's classic worlds, for soft bodies that have met convex
/// shapes.
///
/// Bullet moves rigid bodies before it solves soft bodies. So a soft body stops a rigid one only from the next step on,
/// when it may be through. Bullet also solves contacts before links, which may pull nodes back into the shape. Here
/// contacts come last, and rigid bodies are moved to where their new velocities would have led. Owned by WorldQueries.
class LateImpulses {
 public:
  void clear();
  /// Adds a soft body and the object that it meets. A pair may be added several times. Throws std::bad_alloc.
  void add(btSoftBody& soft, const btCollisionObject& object);
  /// Adds a body with contacts on rigid meshes. They are solved again if links have pulled a node deeper than the
  /// body's margin. Throws std::bad_alloc.
  void add_on_mesh(btSoftBody& soft);

  /// Saves the rigid bodies' velocities. Call it after Bullet has moved rigid bodies, before it solves soft bodies.
  void keep_velocities();
  /// Solves the contacts. Call it once, after Bullet's solver. Skips bodies that are no longer among the world's
  /// objects, and bodies that touch such objects. Adds the impulses to `impulses` for bodies whose solver impulses are
  /// known there, unless it is null.
  void answer(const btCollisionObjectArray& objects, btScalar time_step, ContactImpulses* impulses);

 private:
  struct Rigid {
    btRigidBody* body;
    btVector3 linear, angular;
  };
  std::vector<Rigid> rigid_;
  std::vector<btSoftBody*> soft_;
  std::vector<btSoftBody*> on_meshes_;  ///< solved again only if a node is deep
  std::vector<btVector3> before_;       ///< reserved by add(), so that answer() allocates nothing
};

}  // namespace softcd::bullet
