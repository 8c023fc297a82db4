#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <softcd/bullet/dispatcher.hpp>

#include "patches.hpp"

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  softcd::bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  softcd::bullet::Dispatcher dispatcher(&configuration, broadphase);
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  return check_contacts(world, btSoftBody::fCollision::VF_SS);
}
