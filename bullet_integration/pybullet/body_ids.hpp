#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <vector>

namespace softcd::bullet::pybullet {

/// PyBullet's names for a collision object.
struct ObjectIds {
  std::int32_t body = -1;  ///< the body's unique id; -1 for no object
  std::int32_t link = -1;  ///< the link's index; -1 for a base, a rigid body and a soft body
};

/// Returns PyBullet's names for the object. Null gives the default.
ObjectIds ids_of(const btCollisionObject* object);

/// Returns the soft bodies of the world, in its order.
std::vector<btSoftBody*> soft_bodies_of(const btDynamicsWorld& world);

/// Returns the soft body with this unique id. Throws InvalidInput if there is none.
btSoftBody& soft_body_with(const btDynamicsWorld& world, int id);

}  // namespace softcd::bullet::pybullet
