// Two ropes, links without a face, in a reef knot that is pulled tight at its four ends. Bullet has no contacts of
// links with links: the ropes come apart through each other. With softcd's contacts of edges the knot holds.

#include <softcd/bullet/soft_worlds.hpp>

#include <cstdio>
#include <iterator>
#include <memory>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"

constexpr int kNodes = 101;

/// From the left, or, turned by half a turn, from the right: there, round the other rope's bight, and back.
std::unique_ptr<btSoftBody> make_rope(btSoftBodyWorldInfo& info, btScalar side) {
  const btVector3 half[] = {{-3.8F, 0, 0.35F}, {-2.3F, 0, 0.35F},    {-1.7F, 0.5F, 0.35F},
                            {-1, 0.5F, 0.35F}, {-0.5F, 0, 0.5F},     {0, -0.5F, 0.7F},
                            {0.5F, 0, 1},      {0.95F, 0.35F, 0.9F}, {1.3F, 0.5F, 0.5F}};
  std::vector<btVector3> corners;
  for (const btVector3& p : half) corners.emplace_back(side * p.x(), side * p.y(), p.z());
  for (int i = int(std::size(half)) - 1; i >= 0; --i) corners.push_back(corners[i] * btVector3(1, 1, -1));
  btScalar length = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) length += corners[i].distance(corners[i - 1]);
  std::vector<btVector3> nodes = {corners[0]};
  for (std::size_t i = 1; i < corners.size() && nodes.size() < kNodes;) {
    const btScalar spacing = length / (kNodes - 1);
    const btVector3 rest = corners[i] - nodes.back();
    if (rest.length() < spacing && ++i < corners.size()) continue;
    nodes.push_back(nodes.back() + rest.normalized() * spacing);
  }
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

btScalar stretch(const btSoftBody& rope) {
  btScalar length = 0;
  btScalar rest = 0;
  for (int i = 0; i < rope.m_links.size(); ++i) {
    length += rope.m_links[i].m_n[0]->m_x.distance(rope.m_links[i].m_n[1]->m_x);
    rest += rope.m_links[i].m_rl;
  }
  return length / rest - 1;
}

/// How far the ropes still reach past each other in the end: less than 0 where they have come apart.
btScalar pull(btSoftRigidDynamicsWorld& world) {
  world.getWorldInfo().m_gravity.setZero();
  const std::unique_ptr<btSoftBody> ropes[] = {make_rope(world.getWorldInfo(), 1), make_rope(world.getWorldInfo(), -1)};
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
  btScalar left = -BT_LARGE_FLOAT;
  btScalar right = BT_LARGE_FLOAT;
  for (int i = 0; i < ropes[0]->m_nodes.size(); ++i) left = btMax(left, ropes[0]->m_nodes[i].m_x.x());
  for (int i = 0; i < ropes[1]->m_nodes.size(); ++i) right = btMin(right, ropes[1]->m_nodes[i].m_x.x());
  for (const auto& rope : ropes) world.removeSoftBody(rope.get());
  return left - right;
}

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::Settings settings;
  settings.detection = softcd::Detection::ccd;
  settings.edge_contacts = softcd::bullet::EdgeContacts::respond;
  btSoftRigidDynamicsWorld bullet(&dispatcher, &broadphase, &solver, &configuration);
  const btScalar alone = pull(bullet);
  std::printf("Bullet alone: the knot %s, the ropes overlap by %.2f\n", alone > 0 ? "holds" : "is gone", double(alone));
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr, settings);
  const btScalar with_softcd = pull(world);
  std::printf("with softcd: the knot %s, the ropes overlap by %.2f\n", with_softcd > 0 ? "holds" : "is gone",
              double(with_softcd));
}
