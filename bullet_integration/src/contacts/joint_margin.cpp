#include "contacts/joint_margin.hpp"

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

/// Returns the part of the missing distance to the margin that solving the contact once restores.
btScalar gain_of(const SContact& contact) {
  return contact.m_cfm[0] + contact.m_cfm[1] * contact.m_weights.length2();
}

/// Returns how far the node moves from the faces if each contact is solved once in each of `rounds` rounds, as
/// btSoftBody::PSolve_SContacts does, with no other forces. The contacts are at one place of a surface. So a correction
/// that moves one face moves the others as far.
btVector3 joint_push(Span<const SContact> several, int rounds) {
  btVector3 push(0, 0, 0);
  for (int round = 0; round < rounds; ++round) {
    for (const SContact& contact : several) {
      const btVector3 now = apart(contact, &Node::m_x) + push;
      const btVector3 motion = now - apart(contact, &Node::m_q);
      const btScalar along = contact.m_normal.dot(motion);
      btVector3 correction = (contact.m_normal * along - motion) * contact.m_friction;
      if (along < 0) correction += contact.m_normal * (contact.m_margin - contact.m_normal.dot(now));
      push += correction * gain_of(contact);
    }
  }
  return push;
}

}  // namespace

btScalar approach_of(const SContact& contact) {
  return contact.m_normal.dot(apart(contact, &Node::m_q) - apart(contact, &Node::m_x));
}

btScalar joint_margin(Span<const SContact> several, std::size_t one, int rounds) {
  const SContact& given = several[one];
  const btScalar approach = approach_of(given);
  if (!(approach > 0)) return given.m_margin;
  const btScalar start = given.m_normal.dot(apart(given, &Node::m_x));
  const btScalar push = btMax(btScalar(0), given.m_normal.dot(joint_push(several, rounds)));
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
