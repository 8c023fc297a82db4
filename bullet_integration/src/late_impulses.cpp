#include "late_impulses.hpp"

#include <algorithm>

#include "LinearMath/btTransformUtil.h"

namespace softcd::bullet {
namespace {

/// Several contacts of one node want their turns.
constexpr int kRounds = 4;

void solve_contacts(btSoftBody& body) {
  std::vector<btVector3> before;
  for (int i = 0; i < body.m_nodes.size(); ++i) before.push_back(body.m_nodes[i].m_x);
  for (int round = 0; round < kRounds; ++round) btSoftBody::PSolve_RContacts(&body, 1, 0);
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    btSoftBody::Node& node = body.m_nodes[i];
    node.m_v += (node.m_x - before[static_cast<std::size_t>(i)]) * body.m_sst.isdt;
  }
}

}  // namespace

void LateImpulses::clear() {
  rigid_.clear();
  soft_.clear();
}

void LateImpulses::add(btSoftBody& soft, const btCollisionObject& object) {
  if (std::find(soft_.begin(), soft_.end(), &soft) == soft_.end()) soft_.push_back(&soft);
  auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(&object));
  const bool is_known =
      std::any_of(rigid_.begin(), rigid_.end(), [&](const Rigid& rigid) { return rigid.body == body; });
  if (body != nullptr && body->getInvMass() > 0 && !is_known) rigid_.push_back({body, {}, {}});
}

void LateImpulses::keep_velocities() {
  for (Rigid& rigid : rigid_) {
    rigid.linear = rigid.body->getLinearVelocity();
    rigid.angular = rigid.body->getAngularVelocity();
  }
}

void LateImpulses::answer(Span<btSoftBody* const> bodies, btScalar time_step) {
  for (btSoftBody* body : soft_) {
    // Where a body is to drift back the solver has put its result in place of where the nodes started.
    const bool is_there = std::find(bodies.begin(), bodies.end(), body) != bodies.end();
    if (is_there && body->isActive() && body->m_cfg.diterations <= 0) solve_contacts(*body);
  }
  for (const Rigid& rigid : rigid_) {
    btTransform moved;
    btTransformUtil::integrateTransform(rigid.body->getWorldTransform(),
                                        rigid.body->getLinearVelocity() - rigid.linear,
                                        rigid.body->getAngularVelocity() - rigid.angular, time_step, moved);
    rigid.body->proceedToTransform(moved);
  }
  clear();
}

}  // namespace softcd::bullet
