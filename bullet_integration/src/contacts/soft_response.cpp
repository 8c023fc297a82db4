#include "contacts/soft_response.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "native/arrays.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

/// Bullet's response does not move nodes whose m_constrained is not 0. The bit differs from all that Bullet sets there.
constexpr int kHeldBit = 1 << 30;

/// The split velocity cancels the velocity, which counts in contacts no longer.
void hold(Node& node, bool is_still) {
  node.m_constrained |= kHeldBit;
  if (!is_still) return;
  node.m_splitv = -node.m_v;
  node.m_v.setZero();
}

void let_go(Node& node, bool is_still) {
  node.m_constrained &= ~kHeldBit;
  if (is_still) node.m_v = -node.m_splitv;
}

bool passes(const btSoftBody::DeformableFaceNodeContact& contact, btScalar time_step) {
  const auto apart = [&](btVector3 Node::*member) {
    btVector3 difference = contact.m_node->*member;
    for (int i = 0; i < 3; ++i) difference -= contact.m_bary[i] * (contact.m_face->m_n[i]->*member);
    return contact.m_normal.dot(difference);
  };
  const btScalar gap = apart(&Node::m_x);
  return gap >= 0 && gap + time_step * apart(&Node::m_v) < 0;
}

}  // namespace

InactiveNodesHeld::InactiveNodesHeld(Span<btSoftBody* const> bodies,
                                     const std::function<bool(const btSoftBody&)>& stays)
    : bodies_(bodies), stays_(stays) {
  for (btSoftBody* body : bodies_) {
    if (body->isActive()) continue;
    const bool is_still = stays_(*body);
    for (Node& node : span_of(body->m_nodes)) hold(node, is_still);
  }
}

InactiveNodesHeld::~InactiveNodesHeld() {
  for (btSoftBody* body : bodies_) {
    if (body->isActive()) continue;
    const bool is_still = stays_(*body);
    for (Node& node : span_of(body->m_nodes)) let_go(node, is_still);
  }
}

bool passes_in_contact(Span<btSoftBody* const> bodies, btScalar time_step) {
  return std::any_of(bodies.begin(), bodies.end(), [&](const btSoftBody* body) {
    const auto contacts = span_of(body->m_faceNodeContacts);
    return body->isActive() && std::any_of(contacts.begin(), contacts.end(),
                                           [&](const auto& contact) { return passes(contact, time_step); });
  });
}

void append_shuffled(int count, std::minstd_rand& random, std::vector<int>& order) {
  const auto first = static_cast<std::ptrdiff_t>(order.size());
  order.resize(order.size() + static_cast<std::size_t>(count));
  const Span<int> places(order.data() + first, static_cast<std::size_t>(count));
  std::iota(places.begin(), places.end(), 0);
  for (int& place : places) std::swap(place, places[random() % places.size()]);
}

}  // namespace softcd::bullet
