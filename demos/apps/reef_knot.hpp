#pragma once

#include <cstddef>
#include <iterator>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

/// Returns the positions of the nodes of one rope of a loose reef knot, at equal distances. With side = 1 the rope runs
/// from the left round the other rope's bight and back. With side = -1 it is turned by half a turn, and comes from the
/// right.
inline std::vector<btVector3> reef_knot_rope(btScalar side) {
  constexpr int kNodes = 101;
  const btVector3 half[] = {{-3.8F, 0, 0.35F}, {-2.3F, 0, 0.35F},    {-1.7F, 0.5F, 0.35F},
                            {-1, 0.5F, 0.35F}, {-0.5F, 0, 0.5F},     {0, -0.5F, 0.7F},
                            {0.5F, 0, 1},      {0.95F, 0.35F, 0.9F}, {1.3F, 0.5F, 0.5F}};
  std::vector<btVector3> corners;
  for (const btVector3& p : half) corners.emplace_back(side * p.x(), side * p.y(), p.z());
  for (int i = int(std::size(half)) - 1; i >= 0; --i) corners.push_back(corners[i] * btVector3(1, 1, -1));
  btScalar length = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) length += corners[i].distance(corners[i - 1]);
  std::vector<btVector3> nodes = {corners[0]};
  for (std::size_t i = 1; i < corners.size() && nodes.size() < kNodes;) {
    const btScalar spacing = length / (kNodes - 1);
    const btVector3 rest = corners[i] - nodes.back();
    if (rest.length() < spacing && ++i < corners.size()) continue;
    nodes.push_back(nodes.back() + rest.normalized() * spacing);
  }
  return nodes;
}

/// Returns the rope's elongation as a share of its rest length.
inline btScalar stretch(const btSoftBody& rope) {
  btScalar length = 0;
  btScalar rest = 0;
  for (int i = 0; i < rope.m_links.size(); ++i) {
    length += rope.m_links[i].m_n[0]->m_x.distance(rope.m_links[i].m_n[1]->m_x);
    rest += rope.m_links[i].m_rl;
  }
  return length / rest - 1;
}

/// Returns how far the rope from the left reaches past the rope from the right; negative after they have come apart.
inline btScalar overlap(const btSoftBody& from_left, const btSoftBody& from_right) {
  btScalar left = -BT_LARGE_FLOAT;
  btScalar right = BT_LARGE_FLOAT;
  for (int i = 0; i < from_left.m_nodes.size(); ++i) left = btMax(left, from_left.m_nodes[i].m_x.x());
  for (int i = 0; i < from_right.m_nodes.size(); ++i) right = btMin(right, from_right.m_nodes[i].m_x.x());
  return left - right;
}
