#include "read_out/late_impulses.hpp"

#include <algorithm>

#include "LinearMath/btTransformUtil.h"
#include "read_out/one_by_one.hpp"

namespace softcd::bullet {
namespace {

/// Number of rounds, since a node may have several contacts.
constexpr int kRounds = 4;

/// Adds each contact's impulse to `impulses`, unless that is null. `before` has capacity for the body's nodes.
void solve_contacts(btSoftBody& body, std::vector<btVector3>& before, std::vector<ContactImpulses::Impulse>* impulses) {
  before.clear();
  for (int i = 0; i < body.m_nodes.size(); ++i) before.push_back(body.m_nodes[i].m_x);
  for (int round = 0; round < kRounds; ++round) {
    if (impulses != nullptr) {
      solve_rigid_contacts(body, 0, *impulses);
    } else {
      btSoftBody::PSolve_RContacts(&body, 1, 0);
    }
  }
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    btSoftBody::Node& node = body.m_nodes[i];
    node.m_v += (node.m_x - before[static_cast<std::size_t>(i)]) * body.m_sst.isdt;
  }
}

bool is_among(const btCollisionObjectArray& objects, const btCollisionObject* object) {
  return objects.findLinearSearch(const_cast<btCollisionObject*>(object)) != objects.size();
}

/// Returns false for bodies that drift back (diterations): the solver has overwritten their nodes' start positions with
/// its result.
bool can_be_solved(const btSoftBody& body, const btCollisionObjectArray& objects) {
  if (!is_among(objects, &body) || !body.isActive() || body.m_cfg.diterations > 0) return false;
  const btCollisionObject* last_seen = nullptr;  // contacts with one object follow each other
  for (int i = 0; i < body.m_rcontacts.size(); ++i) {
    const btCollisionObject* const object = body.m_rcontacts[i].m_cti.m_colObj;
    if (object != last_seen && !is_among(objects, object)) return false;
    last_seen = object;
  }
  return true;
}

/// Returns whether a contact, solved again, would move its node back by more than the body's margin. The next step
/// could find the node on the other side.
bool has_deep_node(const btSoftBody& body) {
  const btScalar margin = margin_of(body);
  for (int i = 0; i < body.m_rcontacts.size(); ++i) {
    const btSoftBody::RContact& contact = body.m_rcontacts[i];
    const btSoftBody::Node& node = *contact.m_node;
    const btVector3& normal = contact.m_cti.m_normal;
    const btRigidBody* const rigid = btRigidBody::upcast(contact.m_cti.m_colObj);
    btVector3 motion = node.m_x - node.m_q;
    if (rigid != nullptr) motion -= rigid->getVelocityInLocalPoint(contact.m_c1) * body.m_sst.sdt;
    const btScalar depth = btMin(node.m_x.dot(normal) + contact.m_cti.m_offset, margin);
    if (motion.dot(normal) + depth * contact.m_c4 < -margin) return true;
  }
  return false;
}

}  // namespace

void LateImpulses::clear() {
  rigid_.clear();
  soft_.clear();
  on_meshes_.clear();
}

void LateImpulses::add(btSoftBody& soft, const btCollisionObject& object) {
  before_.reserve(static_cast<std::size_t>(soft.m_nodes.size()));
  if (std::find(soft_.begin(), soft_.end(), &soft) == soft_.end()) soft_.push_back(&soft);
  auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(&object));
  const bool is_known =
      std::any_of(rigid_.begin(), rigid_.end(), [&](const Rigid& rigid) { return rigid.body == body; });
  if (body != nullptr && body->getInvMass() > 0 && !is_known) rigid_.push_back({body, {}, {}});
}

void LateImpulses::add_on_mesh(btSoftBody& soft) {
  before_.reserve(static_cast<std::size_t>(soft.m_nodes.size()));
  if (std::find(on_meshes_.begin(), on_meshes_.end(), &soft) == on_meshes_.end()) on_meshes_.push_back(&soft);
}

void LateImpulses::keep_velocities() {
  for (Rigid& rigid : rigid_) {
    rigid.linear = rigid.body->getLinearVelocity();
    rigid.angular = rigid.body->getAngularVelocity();
  }
}

void LateImpulses::answer(const btCollisionObjectArray& objects, btScalar time_step, ContactImpulses* impulses) {
  const auto has_room = [&](const btSoftBody& body) {
    return static_cast<std::size_t>(body.m_nodes.size()) <= before_.capacity();
  };
  const auto solve = [&](btSoftBody& body) {
    std::vector<ContactImpulses::Impulse>* known =
        impulses != nullptr ? impulses->find(body, ContactArray::rigid_node) : nullptr;
    const bool are_these = known != nullptr && known->size() == static_cast<std::size_t>(body.m_rcontacts.size());
    solve_contacts(body, before_, are_these ? known : nullptr);
  };
  for (btSoftBody* body : soft_) {
    if (can_be_solved(*body, objects) && has_room(*body)) solve(*body);
  }
  for (btSoftBody* body : on_meshes_) {
    const bool is_solved = std::find(soft_.begin(), soft_.end(), body) != soft_.end();
    if (is_solved || !can_be_solved(*body, objects) || !has_room(*body)) continue;
    if (has_deep_node(*body)) solve(*body);
  }
  for (const Rigid& rigid : rigid_) {
    if (!is_among(objects, rigid.body)) continue;
    btTransform moved;
    btTransformUtil::integrateTransform(rigid.body->getWorldTransform(), rigid.body->getLinearVelocity() - rigid.linear,
                                        rigid.body->getAngularVelocity() - rigid.angular, time_step, moved);
    rigid.body->proceedToTransform(moved);
  }
  clear();
}

}  // namespace softcd::bullet
