#pragma once

#include <algorithm>

#include "read_out/contact_read_out.hpp"

/// Makes Bullet's functions, which solve all entries of an array, solve one at a time. The nodes' states before and
/// after then give each entry's impulse.
namespace softcd::bullet {

/// Returns the impulses of solve() on an entry's node and face, from the changes of the member `moved`. Mass times that
/// change times `unit` is momentum. Nodes without mass get no impulse.
template <class SoftEntry, class Solve>
ContactImpulses::Impulse measured_impulse(const SoftEntry& entry, btVector3 btSoftBody::Node::*moved, btScalar unit,
                                          Solve solve) {
  const btSoftBody::Node* const nodes[4] = {entry.m_node, entry.m_face->m_n[0], entry.m_face->m_n[1],
                                            entry.m_face->m_n[2]};
  btVector3 before[4];
  for (int i = 0; i < 4; ++i) before[i] = nodes[i]->*moved;
  solve();
  ContactImpulses::Impulse impulse;
  for (int i = 0; i < 4; ++i) {
    // A face that represents a link may have a node twice.
    const bool is_counted = std::find(nodes, nodes + i, nodes[i]) != nodes + i;
    if (!(nodes[i]->m_im > 0) || is_counted) continue;
    (i == 0 ? impulse.on_owner : impulse.on_other) += (nodes[i]->*moved - before[i]) * (unit / nodes[i]->m_im);
  }
  return impulse;
}

/// Returns whether impulses can move the object: a rigid body with mass, or a multibody's link whose base is free or
/// which a joint on the way to the base can move.
bool is_moved_by_impulses(const btCollisionObject& object);

/// Solves the body's contacts with rigid objects by PSolve_RContacts, and adds their impulses on nodes and objects to
/// `impulses`. A node without mass gets none. An object that no impulse moves gets the opposite of the node's.
void solve_rigid_contacts(btSoftBody& body, btScalar progress, std::vector<ContactImpulses::Impulse>& impulses);

}  // namespace softcd::bullet
