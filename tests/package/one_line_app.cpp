#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <softcd/bullet/soft_worlds.hpp>

#include "patches.hpp"

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btDbvtBroadphase broadphase;
  btCollisionDispatcher dispatcher(&configuration);
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  return check_contacts(world, btSoftBody::fCollision::VF_SS);
}
