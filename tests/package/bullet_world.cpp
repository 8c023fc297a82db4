#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <softcd/bullet/broadphase.hpp>
#include <softcd/bullet/dispatcher.hpp>
#include <softcd/bullet/soft_worlds.hpp>

namespace {

btSoftBody* add_patch(btSoftRigidDynamicsWorld& world, btScalar height) {
  btSoftBody* patch = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), {-1, height, -1}, {1, height, -1},
                                                     {-1, height, 1}, {1, height, 1}, 8, 8, 0, true);
  patch->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  world.addSoftBody(patch);
  return patch;
}

}  // namespace

// Two patches within each other's margins have contacts after one step.
int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  softcd::bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  softcd::bullet::Dispatcher dispatcher(&configuration, broadphase);
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

  const std::unique_ptr<btSoftBody> lower(add_patch(world, 0));
  const std::unique_ptr<btSoftBody> upper(add_patch(world, btScalar(0.1)));
  world.stepSimulation(btScalar(1) / 60, 1);
  const bool touched = lower->m_scontacts.size() + upper->m_scontacts.size() > 0;
  world.removeSoftBody(upper.get());
  world.removeSoftBody(lower.get());
  return touched ? 0 : 1;
}
