#include "contacts/backed_nodes.hpp"

#include <algorithm>
#include <functional>
#include <random>
#include <unordered_set>
#include <utility>

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "contacts/soft_response.hpp"
#include "native/arrays.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

/// A rigid body counts as at most this many nodes: of a larger ratio of masses only rounding would be left.
constexpr btScalar kMostNodes = 10000;

/// Calls visit(node, contact's information, contact) for each node that touches a rigid object. Leaves out inactive
/// bodies: they keep the contacts of an earlier step, whose objects may be gone.
template <class Visit>
void for_each_touch(const btSoftBody& body, const Visit& visit) {
  if (!body.isActive()) return;
  for (int i = 0; i < body.m_nodeRigidContacts.size(); ++i) {
    const auto& contact = body.m_nodeRigidContacts[i];
    visit(*contact.m_node, contact.m_cti, ContactSource{&body, ContactArray::rigid_node, i});
  }
  for (int i = 0; i < body.m_faceRigidContacts.size(); ++i) {
    const auto& contact = body.m_faceRigidContacts[i];
    for (const Node* node : contact.m_face->m_n) {
      visit(*node, contact.m_cti, ContactSource{&body, ContactArray::rigid_face, i});
    }
  }
}

btRigidBody* movable_of(const btSoftBody::sCti& touch) {
  btRigidBody* const rigid = btRigidBody::upcast(const_cast<btCollisionObject*>(touch.m_colObj));
  return rigid != nullptr && rigid->getInvMass() > 0 && rigid->isActive() ? rigid : nullptr;
}

/// Returns the velocity that a rigid body adds to its node, so that both have one velocity along the normal. Without it
/// the node has the velocity `towards` the rigid body.
template <class Backing>
btVector3 common_share(const Backing& backing, btScalar towards) {
  const btScalar node = backing.node->m_im;
  return towards * node / (node + backing.inverse_mass) * backing.normal;
}

bool has_soft_contacts(const btSoftBody* body) {
  return body->isActive() && body->m_faceNodeContacts.size() > 0;
}

}  // namespace

BackedNodes::BackedNodes(Span<btSoftBody* const> bodies) {
  if (std::none_of(bodies.begin(), bodies.end(), has_soft_contacts)) return;
  for (const btSoftBody* body : bodies) {
    for_each_touch(*body, [&](const Node& node, const btSoftBody::sCti& touch, const ContactSource& contact) {
      btRigidBody* const rigid = movable_of(touch);
      if (rigid == nullptr || node.m_constrained == 0 || node.m_im == 0) return;
      const btScalar inverse_mass = rigid->computeImpulseDenominator(node.m_x, touch.m_normal);
      backings_.push_back({&node, rigid, touch.m_normal, std::max(inverse_mass, node.m_im / kMostNodes), contact});
    });
  }
  if (backings_.empty()) return;
  leave_out_held_nodes(bodies);
  std::stable_sort(backings_.begin(), backings_.end(),
                   [](const Backing& a, const Backing& b) { return std::less<const Node*>()(a.node, b.node); });
  keep_first_of_each_pair();
  int most = 0;
  for (const btSoftBody* body : bodies) most = std::max(most, body->m_faceNodeContacts.size());
  std::minstd_rand random;
  append_shuffled(most, random, order_);
}

void BackedNodes::leave_out_held_nodes(Span<btSoftBody* const> bodies) {
  std::unordered_set<const Node*> held;
  for (const btSoftBody* body : bodies) {
    for (const auto& anchor : span_of(body->m_deformableAnchors)) held.insert(anchor.m_node);
    for_each_touch(*body, [&](const Node& node, const btSoftBody::sCti& touch, const ContactSource& /*contact*/) {
      if (movable_of(touch) == nullptr) held.insert(&node);
    });
  }
  std::erase_if(backings_, [&](const Backing& backing) { return held.count(backing.node) > 0; });
}

void BackedNodes::keep_first_of_each_pair() {
  std::vector<Backing> kept;
  for (const Backing& backing : backings_) {
    auto known = kept.rbegin();
    while (known != kept.rend() && known->node == backing.node && known->rigid != backing.rigid) ++known;
    if (known == kept.rend() || known->node != backing.node) kept.push_back(backing);
  }
  backings_ = std::move(kept);
}

Span<const BackedNodes::Backing> BackedNodes::backings_of(const Node& node) const {
  if (node.m_constrained == 0) return {};
  const auto first = std::lower_bound(
      backings_.begin(), backings_.end(), &node,
      [](const Backing& backing, const Node* other) { return std::less<const Node*>()(backing.node, other); });
  const auto last = std::find_if(first, backings_.end(), [&](const Backing& backing) { return backing.node != &node; });
  return {backings_.data() + (first - backings_.begin()), static_cast<std::size_t>(last - first)};
}

bool BackedNodes::has_backed_node(const SoftContact& contact) const {
  if (backings_.empty()) return false;
  const auto is_backed = [&](const Node* node) { return !backings_of(*node).empty(); };
  return is_backed(contact.m_node) || std::any_of(contact.m_face->m_n, contact.m_face->m_n + 3, is_backed);
}

bool BackedNodes::is_held(const Node& node) const {
  return node.m_im == 0 || (node.m_constrained > 0 && backings_of(node).empty());
}

/// Like Bullet, moves no node of a face if one is held: the others would move the faster, the less their weights are.
template <class NodeVisit>
void BackedNodes::for_each_moved(const SoftContact& contact, const btVector3& impulse, const NodeVisit& visit) const {
  if (!is_held(*contact.m_node)) visit(*contact.m_node, impulse);
  Node* const* const nodes = contact.m_face->m_n;
  if (std::any_of(nodes, nodes + 3, [&](const Node* node) { return is_held(*node); })) return;
  for (int i = 0; i < 3; ++i) visit(*nodes[i], -contact.m_bary[i] * impulse);
}

btScalar BackedNodes::speed_apart(const Backing& backing) {
  const btVector3 arm = backing.node->m_x - backing.rigid->getCenterOfMassPosition();
  return backing.normal.dot(backing.node->m_v - backing.rigid->getVelocityInLocalPoint(arm));
}

btScalar BackedNodes::inverse_mass(const SoftContact& contact, const btVector3& direction) const {
  btScalar sum = 0;
  for_each_moved(contact, direction, [&](const Node& node, const btVector3& share) {
    btVector3 change = node.m_im * share;
    btScalar weight = 1;
    for (const Backing& backing : backings_of(node)) {
      const btScalar towards = -change.dot(backing.normal);
      if (!(towards > 0) || speed_apart(backing) > 0) continue;
      change += common_share(backing, towards);
      // One rigid body may back all nodes of the face: then it moves by the sum of their weights, not of the squares.
      weight = share.length();
    }
    if (weight > 0) sum += change.dot(share) / weight;
  });
  return sum;
}

void BackedNodes::push(const SoftContact& contact, const btVector3& impulse, Reader* reader) const {
  for_each_moved(contact, impulse, [&](Node& node, const btVector3& share) {
    btVector3 change = node.m_im * share;
    for (const Backing& backing : backings_of(node)) {
      const btScalar towards = -change.dot(backing.normal) - std::max(btScalar(0), speed_apart(backing));
      if (!(towards > 0)) continue;
      const btVector3 given = common_share(backing, towards) / node.m_im;
      change += node.m_im * given;
      backing.rigid->applyImpulse(-given, node.m_x - backing.rigid->getCenterOfMassPosition());
      if (reader != nullptr) reader->read(backing.contact, node, given);
    }
    node.m_v += change;
  });
}

/// Responds as Bullet does, but with the masses that impulses move, and springs make node and face part no faster than
/// at the speed above which Bullet leaves a contact alone.
void BackedNodes::respond_to(const SoftContact& contact, btScalar stiffness, btScalar time_step, Reader* reader) const {
  const btVector3& normal = contact.m_normal;
  const auto apart = [&](btVector3 Node::*member) {
    btVector3 difference = contact.m_node->*member;
    for (int i = 0; i < 3; ++i) difference -= contact.m_bary[i] * (contact.m_face->m_n[i]->*member);
    return difference;
  };
  const btScalar depth = std::max(btScalar(0), contact.m_margin - normal.dot(apart(&Node::m_x)));
  const btVector3 velocity = apart(&Node::m_v);
  const btScalar speed = normal.dot(velocity);
  const btScalar most = OVERLAP_REDUCTION_FACTOR * depth / time_step;
  const btScalar inverse = inverse_mass(contact, normal);
  if (speed > most || !(inverse > 0)) return;
  const btScalar spring = 2 * stiffness * time_step * depth / (1 + contact.m_bary.length2());
  const btScalar impulse =
      std::max(btScalar(0), -speed) / inverse + std::min(spring, (most - std::max(btScalar(0), speed)) / inverse);
  push(contact, impulse * normal, reader);
  const btVector3 sliding = velocity - speed * normal;
  const btScalar sliding_speed = sliding.safeNorm();
  if (!(sliding_speed > SIMD_EPSILON)) return;
  const btVector3 against = sliding / -sliding_speed;
  const btScalar inverse_along = inverse_mass(contact, against);
  if (!(inverse_along > 0)) return;
  push(contact, std::min(contact.m_friction * impulse, sliding_speed / inverse_along) * against, reader);
}

void BackedNodes::respond_to_only(btSoftBody& body, btScalar time_step, bool with_springs, Reader* reader) const {
  const SoftContact& contact = body.m_faceNodeContacts[0];
  if (has_backed_node(contact)) {
    respond_to(contact, with_springs ? body.m_repulsionStiffness : btScalar(0), time_step, reader);
  } else {
    body.applyRepulsionForce(time_step, with_springs);
  }
}

void BackedNodes::respond(btSoftBody& body, btScalar time_step, bool with_springs) const {
  auto& contacts = body.m_faceNodeContacts;
  const Span<const SoftContact> all = span_of(contacts);
  if (std::none_of(all.begin(), all.end(), [&](const SoftContact& contact) { return has_backed_node(contact); })) {
    body.applyRepulsionForce(time_step, with_springs);
    return;
  }
  for (const int i : order_) {
    if (i >= contacts.size()) continue;
    with_single_entry(contacts, i, [&](const SoftContact& /*contact*/) {
      respond_to_only(body, time_step, with_springs, /*reader=*/nullptr);
    });
  }
}

}  // namespace softcd::bullet
