// A soft ball falls onto a cloth that lies on a box. Prints which bodies touch, since when, and how hard.

#include <softcd/bullet/soft_worlds.hpp>

#include <cstdio>
#include <memory>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"

int main() {
  constexpr btScalar kStep = btScalar(1) / 60;
  softcd::bullet::Settings settings;
  settings.read_out = softcd::bullet::ReadOut::impulses;

  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr, settings);

  btBoxShape box(btVector3(3, 1, 3));
  btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &box));
  world.addRigidBody(&ground);
  const std::unique_ptr<btSoftBody> cloth(
      btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 1.03F, -1), btVector3(1, 1.03F, -1),
                                     btVector3(-1, 1.03F, 1), btVector3(1, 1.03F, 1), 20, 20, 0, true));
  const std::unique_ptr<btSoftBody> ball(btSoftBodyHelpers::CreateEllipsoid(world.getWorldInfo(), btVector3(0, 1.6F, 0),
                                                                            btVector3(0.4F, 0.4F, 0.4F), 200));
  ball->m_cfg.kMT = 0.2F;  // keeps its shape
  for (btSoftBody* body : {cloth.get(), ball.get()}) {
    body->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
    body->m_cfg.piterations = 4;
    body->getCollisionShape()->setMargin(0.03F);
    body->setTotalMass(1);
    body->setPose(/*bvolume=*/false, /*bframe=*/body == ball.get());
    world.addSoftBody(body);
  }
  const auto name = [&](const btCollisionObject* body) {
    return body == cloth.get() ? "cloth" : body == ball.get() ? "ball" : "box";
  };

  for (int step = 0; step < 40; ++step) {
    world.stepSimulation(kStep, 0);
    for (const softcd::bullet::BodyPairContacts& pair : world.detection().body_contacts()) {
      constexpr const char* kStates[] = {"meet", "touch", "part"};
      std::printf("step %2d: %s and %s %s at %zu places, with %.2f N\n", step, name(pair.a), name(pair.b),
                  kStates[static_cast<int>(pair.state)], pair.contacts.size(),
                  static_cast<double>(pair.impulse_b.length() / kStep));
    }
  }
  for (btSoftBody* body : {cloth.get(), ball.get()}) world.removeSoftBody(body);
  world.removeRigidBody(&ground);
}
