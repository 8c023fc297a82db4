#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <softcd/bullet/deformable_world.hpp>

#include "patches.hpp"

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btDbvtBroadphase broadphase;
  btCollisionDispatcher dispatcher(&configuration);
  btDeformableBodySolver deformable_solver;
  btDeformableMultiBodyConstraintSolver solver;
  solver.setDeformableSolver(&deformable_solver);
  softcd::bullet::DeformableWorld world(&dispatcher, &broadphase, &solver, &configuration, &deformable_solver);
  return check_contacts(world, btSoftBody::fCollision::VF_DD);
}
