// Two fingers close on a coarse cloth, in the middle of a face five times as wide as they are, and lift it. Bullet
// tests only nodes against boxes, so the cloth slips through. softcd's contacts of faces and edges hold it.

#include <softcd/bullet/soft_worlds.hpp>

#include <cstdio>
#include <memory>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"

/// Returns how far below the fingers the cloth's top edge is in the end.
btScalar grip(softcd::bullet::ConvexShapes convex_shapes) {
  softcd::bullet::Settings settings;
  settings.convex_shapes = convex_shapes;
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr, settings);

  const std::unique_ptr<btSoftBody> cloth(btSoftBodyHelpers::CreatePatch(
      world.getWorldInfo(), btVector3(-0.75F, 1.5F, 0), btVector3(0.75F, 1.5F, 0), btVector3(-0.75F, 0, 0),
      btVector3(0.75F, 0, 0), 4, 4, /*fixed corners: the upper ones*/ 1 + 2, /*gendiags=*/true));
  cloth->getCollisionShape()->setMargin(0.02F);
  cloth->m_cfg.piterations = 8;
  cloth->m_cfg.kDF = 1;
  world.addSoftBody(cloth.get());

  btBoxShape box(btVector3(0.05F, 0.05F, 0.05F));  // a tenth of a metre; the cloth's edges are half a metre long
  btRigidBody left(0, nullptr, &box);
  btRigidBody right(0, nullptr, &box);
  const auto move_fingers = [&](btScalar distance, btScalar height) {
    for (btRigidBody* finger : {&left, &right}) {
      const btVector3 place(0.1F, height, finger == &left ? -distance : distance);
      finger->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
    }
  };
  move_fingers(0.2F, 1.2F);
  for (btRigidBody* finger : {&left, &right}) {
    finger->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    finger->setActivationState(DISABLE_DEACTIVATION);
    finger->setFriction(1);
    world.addRigidBody(finger);
  }
  constexpr btScalar kStep = btScalar(1) / 60;
  for (int step = 0; step < 150; ++step) {
    const btScalar time = btScalar(step) * kStep;
    if (step == 45) cloth->setTotalMass(1, /*fromfaces=*/true);  // lets the corners go
    move_fingers(0.2F - 0.145F * btMin(2 * time, btScalar(1)), 1.2F + 0.5F * btMax(time - 1, btScalar(0)));
    world.stepSimulation(kStep, 0);
  }
  const btScalar below = left.getWorldTransform().getOrigin().y() - cloth->m_nodes[0].m_x.y();
  world.removeSoftBody(cloth.get());
  for (btRigidBody* finger : {&left, &right}) world.removeRigidBody(finger);
  return below;
}

int main() {
  using softcd::bullet::ConvexShapes;
  for (const ConvexShapes convex_shapes : {ConvexShapes::nodes, ConvexShapes::faces_and_edges}) {
    const btScalar below = grip(convex_shapes);
    std::printf("%s: the cloth %s, its corner is %.2f below the fingers\n",
                convex_shapes == ConvexShapes::nodes ? "nodes alone" : "faces and edges", below < 1 ? "holds" : "slips",
                static_cast<double>(below));
  }
}
