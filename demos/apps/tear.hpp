#pragma once

#include <utility>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

/// Two nodes that a link joins.
using Ends = std::pair<int, int>;

/// Returns some of the links that are at least `stretch` times as long as at rest, and not short at rest.
inline std::vector<Ends> overstretched_links(const btSoftBody& cloth, btScalar stretch, btScalar shortest) {
  constexpr int kMost = 8;
  std::vector<Ends> found;
  for (int l = 0; l < cloth.m_links.size() && found.size() < kMost; ++l) {
    const btSoftBody::Link& link = cloth.m_links[l];
    const btScalar length = (link.m_n[1]->m_x - link.m_n[0]->m_x).length();
    if (link.m_rl < shortest || length < stretch * link.m_rl) continue;
    const btSoftBody::Node* const first = &cloth.m_nodes[0];
    found.emplace_back(int(link.m_n[0] - first), int(link.m_n[1] - first));
  }
  return found;
}

/// Cuts a link, and the faces beside it, in two: it adds new nodes, links and faces. A new node weighs as much as the
/// link's lighter end. The cut gapes by a hundredth of the link, so that its sides do not touch. Returns false where
/// the link no longer exists.
inline bool cut(btSoftBody& cloth, const Ends& link) {
  const btScalar inverse_mass = btMax(cloth.m_nodes[link.first].m_im, cloth.m_nodes[link.second].m_im);
  if (inverse_mass <= 0 || !cloth.cutLink(link.first, link.second, btScalar(0.5))) return false;
  const int first_new = cloth.m_nodes.size() - 2;
  for (int side = 0; side < 2; ++side) {
    btSoftBody::Node& node = cloth.m_nodes[first_new + side];
    node.m_x = node.m_q = node.m_x.lerp(cloth.m_nodes[side == 0 ? link.first : link.second].m_x, btScalar(0.01));
    cloth.setMass(first_new + side, 1 / inverse_mass);
  }
  return true;
}
