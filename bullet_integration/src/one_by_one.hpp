#pragma once

#include <algorithm>

#include "contact_read_out.hpp"

/// Makes Bullet's functions that answer all entries of an array answer one at a time, so that each one's impulse can be
/// told from what its nodes had before and have after it.
namespace softcd::bullet {

/// Calls visit(entry) while the array has no other entry than the i-th, which stands first in it.
template <class Entry, class Visit>
void with_single_entry(btAlignedObjectArray<Entry>& array, int i, Visit visit) {
  const int count = array.size();
  Entry* const entries = &array[0];
  if (i > 0) btSwap(entries[0], entries[i]);
  array.resizeNoInitialize(1);
  visit(static_cast<const Entry&>(entries[0]));
  array.resizeNoInitialize(count);
  if (i > 0) btSwap(entries[0], entries[i]);
}

/// What solve() gives to the node and to the face of an entry, as changes of `moved`; mass times that times `unit` is
/// momentum. Nodes without mass are given nothing.
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
    // What stands for a link may have a node twice.
    const bool is_counted = std::find(nodes, nodes + i, nodes[i]) != nodes + i;
    if (!(nodes[i]->m_im > 0) || is_counted) continue;
    (i == 0 ? impulse.on_owner : impulse.on_other) += (nodes[i]->*moved - before[i]) * (unit / nodes[i]->m_im);
  }
  return impulse;
}

}  // namespace softcd::bullet
