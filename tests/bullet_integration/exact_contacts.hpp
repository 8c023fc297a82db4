#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "BulletSoftBody/btSoftBody.h"
#include "reference_distance.hpp"
#include "scenes/vectors.hpp"

namespace softcd::test {

inline Vec3d position_of(const btSoftBody::Node& node) {
  return demo::to_vec3d(node.m_x);
}

inline long double distance_of(const btSoftBody::Node& node, const btSoftBody::Face& face) {
  return distance_vertex_triangle(position_of(node), position_of(*face.m_n[0]), position_of(*face.m_n[1]),
                                  position_of(*face.m_n[2]));
}
inline long double distance_of(const btSoftBody::SContact& contact) {
  return distance_of(*contact.m_node, *contact.m_face);
}

/// Every node of `nodes` within reach of a face of `faces` has just that contact, and no other. Nothing moves here,
/// so the margin is the sum of both bodies'.
inline void expect_exact_contacts(const btSoftBody& nodes, const btSoftBody& faces) {
  std::set<std::pair<const btSoftBody::Node*, const btSoftBody::Face*>> found;
  for (int i = 0; i < nodes.m_scontacts.size(); ++i) {
    const btSoftBody::SContact& contact = nodes.m_scontacts[i];
    if (contact.m_face >= &faces.m_faces[0] && contact.m_face < &faces.m_faces[0] + faces.m_faces.size()) {
      found.emplace(contact.m_node, contact.m_face);
    }
  }
  const double margin = double(nodes.getCollisionShape()->getMargin()) + double(faces.getCollisionShape()->getMargin());
  std::size_t expected_count = 0;
  for (int n = 0; n < nodes.m_nodes.size(); ++n) {
    for (int f = 0; f < faces.m_faces.size(); ++f) {
      const btSoftBody::Face& face = faces.m_faces[f];
      const auto distance = static_cast<double>(distance_of(nodes.m_nodes[n], face));
      if (std::abs(distance - margin) < 1e-6) continue;
      expected_count += distance < margin;
      EXPECT_EQ(found.count({&nodes.m_nodes[n], &face}), distance < margin ? 1U : 0U);
    }
  }
  EXPECT_GT(expected_count, 0U);
}

inline void expect_exact_contacts_between(const btSoftBody& a, const btSoftBody& b) {
  expect_exact_contacts(a, b);
  expect_exact_contacts(b, a);
}

}  // namespace softcd::test
