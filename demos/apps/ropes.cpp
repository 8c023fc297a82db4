// Two ropes, made of links without faces, in a reef knot that is pulled tight at its four ends. Bullet has no contacts
// between links, so the ropes pass through each other and come apart. With softcd's contacts of edges the knot holds.

#include <softcd/bullet/soft_worlds.hpp>

#include <cstdio>
#include <memory>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "reef_knot.hpp"

std::unique_ptr<btSoftBody> make_rope(btSoftBodyWorldInfo& info, const std::vector<btVector3>& nodes) {
  auto rope = std::make_unique<btSoftBody>(&info, int(nodes.size()), nodes.data(), nullptr);
  for (int i = 1; i < rope->m_nodes.size(); ++i) rope->appendLink(i - 1, i);
  rope->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  rope->m_cfg.piterations = 20;
  rope->m_cfg.kDP = 0.05F;
  rope->getCollisionShape()->setMargin(0.03F);
  rope->setSelfCollision(true);
  rope->setTotalMass(1);
  for (const int end : {0, rope->m_nodes.size() - 1}) rope->setMass(end, 0);
  return rope;
}

void pull(btSoftRigidDynamicsWorld& world, const char* what) {
  world.getWorldInfo().m_gravity.setZero();
  const std::unique_ptr<btSoftBody> ropes[] = {make_rope(world.getWorldInfo(), reef_knot_rope(1)),
                                               make_rope(world.getWorldInfo(), reef_knot_rope(-1))};
  for (const auto& rope : ropes) world.addSoftBody(rope.get());
  for (int step = 0; step < 360; ++step) {
    for (const auto& rope : ropes) {
      const btScalar speed = stretch(*rope) < 0.05F ? 1 : 0;
      for (const int end : {0, rope->m_nodes.size() - 1}) {
        rope->m_nodes[end].m_v.setValue(rope == ropes[0] ? -speed : speed, 0, 0);
      }
    }
    world.stepSimulation(btScalar(1) / 60, 0);
  }
  const double left = overlap(*ropes[0], *ropes[1]);
  std::printf("%s: the knot %s, the ropes overlap by %.2f\n", what, left > 0 ? "holds" : "is gone", left);
  for (const auto& rope : ropes) world.removeSoftBody(rope.get());
}

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld bullet(&dispatcher, &broadphase, &solver, &configuration);
  pull(bullet, "Bullet alone");
  softcd::bullet::Settings settings;
  settings.detection = softcd::Detection::ccd;
  settings.edge_contacts = softcd::bullet::EdgeContacts::respond;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr, settings);
  pull(world, "with softcd");
}
