#include "contacts/soft_response.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "native/arrays.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

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
