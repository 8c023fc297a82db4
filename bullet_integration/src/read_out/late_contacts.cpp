#include "read_out/late_contacts.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

#include "bodies/node_ends.hpp"
#include "native/arrays.hpp"
#include "read_out/one_by_one.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

const Node* first_node(const btSoftBody& body) {
  return body.m_nodes.size() > 0 ? &body.m_nodes[0] : nullptr;
}

const btSoftBody::Face* first_face(const btSoftBody& body) {
  return body.m_faces.size() > 0 ? &body.m_faces[0] : nullptr;
}

bool is_before(const Node* a, const Node* b) {
  return std::less<>()(a, b);
}

void add_once(std::vector<std::uint32_t>& places, std::uint32_t place) {
  const auto at = std::lower_bound(places.begin(), places.end(), place);
  if (at == places.end() || *at != place) places.insert(at, place);
}

/// Returns whether Bullet's solver solves the body's contacts, and leaves its nodes' positions at the start of the
/// step.
bool can_be_solved(const btSoftBody& body) {
  const auto& sequence = body.m_cfg.m_psequence;
  return body.isActive() && body.m_cfg.piterations > 0 && body.m_cfg.diterations <= 0 &&
         sequence.findLinearSearch(btSoftBody::ePSolver::SContacts) != sequence.size();
}

/// Returns the vector from the contact's point on the face to the node.
btVector3 separation(const btSoftBody::SContact& contact, btVector3 Node::*position) {
  btVector3 result = contact.m_node->*position;
  for (int i = 0; i < 3; ++i) result -= contact.m_weights[i] * (contact.m_face->m_n[i]->*position);
  return result;
}

/// Moves node and face apart up to `margins`, but no farther than they were when the step began. Bullet's own margin
/// grows with the node's motion: pushes by it, which come after all velocities are set, would throw stiff bodies.
/// Returns whether anything has moved.
bool push_apart(const btSoftBody::SContact& contact, btScalar margins) {
  const btScalar gap_at_start = contact.m_normal.dot(separation(contact, &Node::m_q));
  const btScalar wanted = btMin(btMin(margins, contact.m_margin), gap_at_start);
  const btScalar lacking = wanted - contact.m_normal.dot(separation(contact, &Node::m_x));
  if (!(lacking > 0)) return false;
  const btVector3 push = lacking * contact.m_normal;
  contact.m_node->m_x += contact.m_cfm[0] * push;
  for (int i = 0; i < 3; ++i) contact.m_face->m_n[i]->m_x -= (contact.m_cfm[1] * contact.m_weights[i]) * push;
  return true;
}

}  // namespace

void LateContacts::Body::reset(btSoftBody& of) {
  body = &of;
  nodes = first_node(of);
  faces = first_face(of);
  touched.clear();
  others.clear();
  is_pushed_late = is_moved = false;
}

bool LateContacts::NodeOwners::Range::has(const Node* node) const {
  return !is_before(node, begin) && is_before(node, end);
}

void LateContacts::NodeOwners::reset(Span<btSoftBody* const> bodies) {
  ranges_.clear();
  last_ = 0;
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    const Node* const begin = first_node(*bodies[i]);
    if (begin != nullptr) ranges_.push_back({begin, begin + bodies[i]->m_nodes.size(), i});
  }
  std::sort(ranges_.begin(), ranges_.end(), [](const Range& a, const Range& b) { return is_before(a.begin, b.begin); });
}

std::uint32_t LateContacts::NodeOwners::owner_of(const Node* node) {
  if (last_ < ranges_.size() && ranges_[last_].has(node)) return ranges_[last_].owner;
  const auto after = std::upper_bound(ranges_.begin(), ranges_.end(), node,
                                      [](const Node* n, const Range& range) { return is_before(n, range.begin); });
  if (after == ranges_.begin() || !std::prev(after)->has(node)) return kNoIndex;
  last_ = static_cast<std::size_t>(std::prev(after) - ranges_.begin());
  return ranges_[last_].owner;
}

void LateContacts::find(Span<btSoftBody* const> bodies) {
  clear();
  if (bodies.size() < 3) return;
  owners_.reset(bodies);
  if (bodies.size() > bodies_.size()) bodies_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) bodies_[i].reset(*bodies[i]);
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    Body& each = bodies_[i];
    for (const btSoftBody::SContact& contact : span_of(each.body->m_scontacts)) {
      const std::uint32_t other = owners_.owner_of(contact.m_face->m_n[0]);
      each.others.push_back(other != kNoIndex ? other : i);
      if (each.others.back() == i) continue;
      add_once(each.touched, other);
      add_once(bodies_[other].touched, i);
    }
  }
  count_ = bodies.size();
  for (std::uint32_t i = 0; i < count_; ++i) {
    Body& each = bodies_[i];
    each.is_pushed_late = std::any_of(each.touched.begin(), each.touched.end(),
                                      [&](std::uint32_t other) { return is_pushed_late(i, other); });
  }
}

/// Returns whether a body that touches one of these two is solved after both.
bool LateContacts::is_pushed_late(std::uint32_t one, std::uint32_t other) const {
  return std::max(bodies_[one].touched.back(), bodies_[other].touched.back()) > std::max(one, other);
}

/// Pushes the features of the body's contacts apart. The contact's own body stands for an unknown other one.
void LateContacts::solve(Body& owner, ContactImpulses* impulses) {
  btSoftBody& body = *owner.body;
  std::vector<ContactImpulses::Impulse>* known =
      impulses != nullptr ? impulses->find(body, ContactArray::soft) : nullptr;
  if (known != nullptr && known->size() != static_cast<std::size_t>(body.m_scontacts.size())) known = nullptr;
  for (int i = 0; i < body.m_scontacts.size(); ++i) {
    const btSoftBody::SContact& contact = body.m_scontacts[i];
    Body& other = bodies_[owner.others[static_cast<std::size_t>(i)]];
    const btScalar margins = margin_of(body) + margin_of(*other.body);
    bool are_pushed = false;
    const auto push = [&] { are_pushed = push_apart(contact, margins); };
    if (known == nullptr) {
      push();
    } else {
      (*known)[static_cast<std::size_t>(i)] += measured_impulse(contact, &Node::m_x, body.m_sst.isdt, push);
    }
    if (are_pushed) owner.is_moved = other.is_moved = true;
  }
}

void LateContacts::solve(Span<btSoftBody* const> bodies, ContactImpulses* impulses) {
  const auto is_unchanged = [&](const Body& each) {
    return std::find(bodies.begin(), bodies.end(), each.body) != bodies.end() && each.nodes == first_node(*each.body) &&
           each.faces == first_face(*each.body);
  };
  for (std::size_t i = count_; i-- > 0;) {
    Body& each = bodies_[i];
    if (!each.is_pushed_late || !is_unchanged(each) || !can_be_solved(*each.body)) continue;
    if (each.others.size() != static_cast<std::size_t>(each.body->m_scontacts.size())) continue;
    const bool are_there = std::all_of(each.touched.begin(), each.touched.end(),
                                       [&](std::uint32_t other) { return is_unchanged(bodies_[other]); });
    if (!are_there) continue;
    solve(each, impulses);
  }
  for (const Body& each : found()) {
    if (each.is_moved) each.body->updateNormals();
  }
  clear();
}

}  // namespace softcd::bullet
