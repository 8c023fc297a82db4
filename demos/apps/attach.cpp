// Cloths are thrown at a held cloth in a world that an engine has made: before softcd is attached, while it is
// attached, and afterwards.

#include <softcd/bullet/attach.hpp>

#include <cstdio>
#include <memory>
#include <optional>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "BulletSoftBody/btSoftRigidDynamicsWorld.h"

/// Represents an engine that the application cannot change.
struct Engine {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};

  std::unique_ptr<btSoftBody> add_cloth(btScalar height, btScalar half_side) {
    std::unique_ptr<btSoftBody> cloth(btSoftBodyHelpers::CreatePatch(
        world.getWorldInfo(), btVector3(-half_side, height, -half_side), btVector3(half_side, height, -half_side),
        btVector3(-half_side, height, half_side), btVector3(half_side, height, half_side), 20, 20, 0, true));
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
    cloth->getCollisionShape()->setMargin(0.02F);
    world.addSoftBody(cloth.get());
    return cloth;
  }
};

int main() {
  Engine engine;
  std::optional<softcd::bullet::Attachment> attachment;
  for (const char* who : {"Bullet", "softcd", "Bullet again"}) {
    if (who[0] == 's') {  // the world runs already
      softcd::bullet::Settings settings;
      settings.detection = softcd::Detection::ccd;
      attachment = softcd::bullet::attach(engine.world, settings);
      for (const softcd::bullet::Limitation& limitation : attachment->limitations()) {
        std::printf("(%.*s)\n", static_cast<int>(limitation.text.size()), limitation.text.data());
      }
    } else if (attachment.has_value()) {
      attachment->detach();  // from here on the world works as without softcd
    }

    const std::unique_ptr<btSoftBody> held = engine.add_cloth(0, 1);
    for (int i = 0; i < held->m_nodes.size(); ++i) held->setMass(i, 0);
    const std::unique_ptr<btSoftBody> thrown = engine.add_cloth(1, 0.5F);
    thrown->setVelocity(btVector3(0, -100, 0));
    for (int step = 0; step < 6; ++step) {
      engine.world.stepSimulation(btScalar(1) / 60, 0);
      if (attachment.has_value()) attachment->finish_step();
    }
    int below = 0;
    for (int i = 0; i < thrown->m_nodes.size(); ++i) below += thrown->m_nodes[i].m_x.y() < 0 ? 1 : 0;
    std::printf("%s: %d of %d nodes have passed through\n", who, below, thrown->m_nodes.size());
    for (btSoftBody* body : {held.get(), thrown.get()}) engine.world.removeSoftBody(body);
  }
}
