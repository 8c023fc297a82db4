#include "contacts/joint_margin.hpp"

#include <array>
#include <vector>

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;
using SContact = btSoftBody::SContact;

/// Returns the vector from the contact's point on the face to the node.
btVector3 apart(const SContact& contact, btVector3 Node::*position) {
  btVector3 apart = contact.m_node->*position;
  for (int i = 0; i < 3; ++i) apart -= contact.m_weights[i] * (contact.m_face->m_n[i]->*position);
  return apart;
}

/// Simulates Bullet's solver for a node and the faces that it touches, with no other forces.
class Turns {
 public:
  explicit Turns(Span<const SContact> several) {
    turns_.reserve(several.size());
    nodes_.reserve(1 + 3 * several.size());
    places_.reserve(1 + 3 * several.size());
    places_.push_back(several[0].m_node->m_x);
    nodes_.push_back(several[0].m_node);
    for (const SContact& contact : several) {
      Turn turn{&contact, apart(contact, &Node::m_q), {}};
      for (std::size_t i = 0; i < 3; ++i) turn.corners[i] = place_of(*contact.m_face->m_n[i]);
      turns_.push_back(turn);
    }
  }

  /// Solves each contact once, as btSoftBody::PSolve_SContacts does.
  void answer() {
    for (const Turn& turn : turns_) {
      const SContact& contact = *turn.contact;
      const btVector3 now = apart_now(turn);
      const btVector3 motion = now - turn.apart_at_start;
      const btScalar along = contact.m_normal.dot(motion);
      btVector3 correction = (contact.m_normal * along - motion) * contact.m_friction;
      if (along < 0) correction += contact.m_normal * (contact.m_margin - contact.m_normal.dot(now));
      places_[0] += correction * contact.m_cfm[0];
      if (contact.m_cfm[1] == 0) continue;
      for (int i = 0; i < 3; ++i) {
        places_[turn.corners[static_cast<std::size_t>(i)]] -= correction * (contact.m_cfm[1] * contact.m_weights[i]);
      }
    }
  }

  /// Returns the distance of the node from its face along the normal.
  btScalar separation(std::size_t i) const { return turns_[i].contact->m_normal.dot(apart_now(turns_[i])); }

 private:
  struct Turn {
    const SContact* contact;
    btVector3 apart_at_start;
    std::array<std::size_t, 3> corners;  ///< in places_
  };

  /// Searches linearly, as a node's contacts have few nodes. Begins with the last ones, because faces with consecutive
  /// numbers are often neighbours.
  std::size_t place_of(const Node& node) {
    std::size_t behind = nodes_.size();
    while (behind > 0 && nodes_[behind - 1] != &node) --behind;
    if (behind > 0) return behind - 1;
    nodes_.push_back(&node);
    places_.push_back(node.m_x);
    return nodes_.size() - 1;
  }

  btVector3 apart_now(const Turn& turn) const {
    btVector3 apart = places_[0];
    for (int i = 0; i < 3; ++i) {
      apart -= turn.contact->m_weights[i] * places_[turn.corners[static_cast<std::size_t>(i)]];
    }
    return apart;
  }

  std::vector<const Node*> nodes_;
  std::vector<btVector3> places_;  ///< of nodes_; the first is the node of all contacts
  std::vector<Turn> turns_;
};

/// Returns the part of the missing distance to the margin that solving the contact once restores.
btScalar gain_of(const SContact& contact) {
  return contact.m_cfm[0] + contact.m_cfm[1] * contact.m_weights.length2();
}

}  // namespace

btScalar approach_of(const SContact& contact) {
  return contact.m_normal.dot(apart(contact, &Node::m_q) - apart(contact, &Node::m_x));
}

btScalar joint_margin(Span<const SContact> several, std::size_t one, int rounds) {
  const SContact& given = several[one];
  const btScalar approach = approach_of(given);
  if (!(approach > 0)) return given.m_margin;
  Turns turns(several);
  const btScalar start = turns.separation(one);
  for (int round = 0; round < rounds; ++round) turns.answer();
  const btScalar push = btMax(btScalar(0), turns.separation(one) - start);
  // Bullet solves a contact in each round until its approach has ended. If the several contacts leave a part of the
  // approach, contacts of the face's other nodes end that part. A contact that pushes no farther than the several would
  // then pull its node back.
  btScalar lacking = 1;
  for (int round = 1; round <= rounds; ++round) {
    const btScalar lacking_before = lacking;
    lacking *= 1 - gain_of(given);
    const btScalar depth = btMax(push, approach) / (1 - lacking);
    const bool is_last = round == rounds || push >= approach;
    const bool is_reached = depth * (1 - lacking_before) <= approach;
    if (is_last && is_reached && start + depth < given.m_margin) return start + depth;
  }
  return given.m_margin;
}

}  // namespace softcd::bullet
