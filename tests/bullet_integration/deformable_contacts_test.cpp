// The deformable world's contacts, step by step, compared with those of Bullet's own detection.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <set>
#include <utility>

#include "BulletSoftBody/btSoftBodyInternals.h"
#include "deformable_support.hpp"
#include "exact_contacts.hpp"

namespace softcd::test {
namespace {

using demo::DeformableSimulation;

/// A contact by the places of its bodies, node and face.
struct NodeFace {
  int node_body, node, face_body, face;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes what this compares with for a pointer.
  friend auto operator<=>(const NodeFace&, const NodeFace&) = default;
};
using NodeFaces = std::multiset<NodeFace>;

using DeformableContact = btSoftBody::DeformableFaceNodeContact;

NodeFace node_face_of(const btAlignedObjectArray<btSoftBody*>& bodies, int node_body,
                      const DeformableContact& contact) {
  int face_body = 0;
  while (bodies[face_body] != contact.m_colObj) ++face_body;
  return {node_body, static_cast<int>(contact.m_node - &bodies[node_body]->m_nodes[0]), face_body,
          static_cast<int>(contact.m_face - &bodies[face_body]->m_faces[0])};
}

std::multimap<NodeFace, DeformableContact> contacts_of(const btAlignedObjectArray<btSoftBody*>& bodies) {
  std::multimap<NodeFace, DeformableContact> result;
  for (int b = 0; b < bodies.size(); ++b) {
    for (int i = 0; i < bodies[b]->m_faceNodeContacts.size(); ++i) {
      const DeformableContact& contact = bodies[b]->m_faceNodeContacts[i];
      result.emplace(node_face_of(bodies, b, contact), contact);
    }
  }
  return result;
}

NodeFaces pairs_of(const btAlignedObjectArray<btSoftBody*>& bodies) {
  NodeFaces result;
  for (const auto& [pair, contact] : contacts_of(bodies)) result.insert(pair);
  return result;
}

bool share_node(const btSoftBody::Face& a, const btSoftBody::Face& b) {
  for (const btSoftBody::Node* node : a.m_n) {
    if (std::find(b.m_n, b.m_n + 3, node) != b.m_n + 3) return true;
  }
  return false;
}

bool has_face_away_from(const btSoftBody& body, const btSoftBody::Node& node, const btSoftBody::Face& face) {
  for (int f = 0; f < body.m_faces.size(); ++f) {
    const btSoftBody::Face& other = body.m_faces[f];
    if (std::find(other.m_n, other.m_n + 3, &node) != other.m_n + 3 && !share_node(other, face)) return true;
  }
  return false;
}

/// Returns the pairs of nodes and faces that Bullet's predicate accepts, at the bodies' present positions.
NodeFaces expected_contacts(const btAlignedObjectArray<btSoftBody*>& bodies) {
  NodeFaces result;
  for (int a = 0; a < bodies.size(); ++a) {
    for (int b = 0; b < bodies.size(); ++b) {
      btSoftBody& node_body = *bodies[a];
      btSoftBody& face_body = *bodies[b];
      if (a == b && !node_body.useSelfCollision()) continue;
      const btScalar margin = node_body.getCollisionShape()->getMargin() + face_body.getCollisionShape()->getMargin();
      for (int n = 0; n < node_body.m_nodes.size(); ++n) {
        for (int f = 0; f < face_body.m_faces.size(); ++f) {
          const btSoftBody::Face& face = face_body.m_faces[f];
          const btSoftBody::Node& node = node_body.m_nodes[n];
          const btVector3 normal =
              (face.m_n[1]->m_x - face.m_n[0]->m_x).cross(face.m_n[2]->m_x - face.m_n[0]->m_x).normalized();
          btVector3 weights;
          if (!proximityTest(face.m_n[0]->m_x, face.m_n[1]->m_x, face.m_n[2]->m_x, node.m_x, normal, margin, weights))
            continue;
          if (a == b && !has_face_away_from(face_body, node, face)) continue;
          result.insert({a, n, b, f});
        }
      }
    }
  }
  return result;
}

std::size_t count_missing(const NodeFaces& from, const NodeFaces& wanted) {
  std::size_t missing = 0;
  for (auto pair = wanted.begin(); pair != wanted.end(); pair = wanted.upper_bound(*pair)) {
    missing += static_cast<std::size_t>(from.count(*pair) == 0);
  }
  return missing;
}

/// Two wavy sheets within each other's reach, whose triangles are large enough for Bullet's float predicate.
std::unique_ptr<DeformableSimulation> wavy_sheets(const std::optional<bullet::Settings>& settings) {
  auto simulation = std::make_unique<DeformableSimulation>(settings);
  for (int i = 0; i < 2; ++i) {
    SheetOptions options;
    options.nodes_per_side = i == 0 ? 9 : 12;
    options.margin = btScalar(0.04);
    auto sheet = make_sheet(simulation->world_info(), options);
    for (int n = 0; n < sheet->m_nodes.size(); ++n) {
      btSoftBody::Node& node = sheet->m_nodes[n];
      node.m_x.setY(btScalar(0.05) * btScalar(i) +
                    btScalar(0.06) * btSin(7 * node.m_x.x() + btScalar(i)) * btCos(5 * node.m_x.z()));
      node.m_q = node.m_x;
    }
    sheet->updateNormals();
    simulation->add(std::move(sheet));
  }
  return simulation;
}

/// A long roll.
std::unique_ptr<DeformableSimulation> rolled_strip(const std::optional<bullet::Settings>& settings) {
  auto simulation = std::make_unique<DeformableSimulation>(settings);
  auto strip = make_roll(simulation->world_info(), 60, 6);
  strip->setSelfCollision(true);
  simulation->add(std::move(strip));
  return simulation;
}

using MakeScene = std::unique_ptr<DeformableSimulation> (*)(const std::optional<bullet::Settings>&);

NodeFaces contacts_after_a_step(MakeScene make, const std::optional<bullet::Settings>& settings, NodeFaces* expected) {
  const auto simulation = make(settings);
  const btAlignedObjectArray<btSoftBody*>& bodies = simulation->world().getSoftBodyArray();
  if (expected != nullptr) *expected = expected_contacts(bodies);
  simulation->step(kStep);
  return pairs_of(bodies);
}

class DeformableContacts : public testing::TestWithParam<std::pair<const char*, MakeScene>> {};
INSTANTIATE_TEST_SUITE_P(Scenes, DeformableContacts,
                         testing::Values(std::pair("wavy_sheets", MakeScene(wavy_sheets)),
                                         std::pair("rolled_strip", MakeScene(rolled_strip))),
                         [](const auto& parameter) { return std::string(parameter.param.first); });

/// Between bodies these are Bullet's. Within a body Bullet's trees, whose cones of normals leave out some, enter others
/// several times.
TEST_P(DeformableContacts, are_those_of_bullets_trees_once_each) {
  NodeFaces by_predicate;
  const NodeFaces found = contacts_after_a_step(GetParam().second, test_settings(), &by_predicate);
  const NodeFaces native = contacts_after_a_step(GetParam().second, std::nullopt, nullptr);
  std::cout << GetParam().first << ": " << found.size() << " contacts of " << by_predicate.size()
            << " that Bullet's predicate has; Bullet's trees miss " << count_missing(native, found) << '\n';
  EXPECT_GT(found.size(), 300U);
  EXPECT_EQ(count_missing(by_predicate, found), 0U);
  EXPECT_EQ(count_missing(found, native), 0U) << "a contact that only Bullet has";
  EXPECT_EQ(std::set(found.begin(), found.end()).size(), found.size()) << "a contact twice";
  for (const NodeFace& pair : found) {
    if (pair.node_body == pair.face_body) continue;
    EXPECT_EQ(native.count(pair), 1U) << "a contact that Bullet has not";
  }
}

/// With `closest_feature`, too, which leaves out contacts in classic worlds only.
TEST_P(DeformableContacts, are_all_given_whatever_the_choice) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    bullet::Settings settings = test_settings(detection);
    settings.edge_contacts = bullet::EdgeContacts::respond;
    const NodeFaces all = contacts_after_a_step(GetParam().second, settings, nullptr);
    EXPECT_GT(all.size(), 300U);
    settings.contacts = bullet::Contacts::closest_feature;
    EXPECT_EQ(contacts_after_a_step(GetParam().second, settings, nullptr), all);
  }
}

/// Returns how near each node comes to each body in these contacts.
std::map<std::array<int, 3>, long double> nearest_of(const NodeFaces& contacts,
                                                     const btAlignedObjectArray<btSoftBody*>& bodies) {
  std::map<std::array<int, 3>, long double> nearest;
  for (const NodeFace& each : contacts) {
    const long double distance =
        distance_of(bodies[each.node_body]->m_nodes[each.node], bodies[each.face_body]->m_faces[each.face]);
    const auto [place, is_new] = nearest.try_emplace({each.node_body, each.node, each.face_body}, distance);
    place->second = std::min(place->second, distance);
  }
  return nearest;
}

/// A node beside a face may be nearer to the face's plane than to any face.
TEST_P(DeformableContacts, with_a_bound_are_the_nearest) {
  const auto at_start = GetParam().second(std::nullopt);
  const btAlignedObjectArray<btSoftBody*>& bodies = at_start->world().getSoftBodyArray();
  bullet::Settings settings = test_settings();
  const auto all = nearest_of(contacts_after_a_step(GetParam().second, settings, nullptr), bodies);
  settings.contacts_per_node = 1;
  const auto left = nearest_of(contacts_after_a_step(GetParam().second, settings, nullptr), bodies);
  ASSERT_EQ(left.size(), all.size());
  for (const auto& [site, distance] : all) EXPECT_NEAR(double(left.at(site)), double(distance), 2e-6);
}

/// Bullet's values of a contact that both worlds have.
TEST_P(DeformableContacts, have_bullets_values) {
  const auto ours = GetParam().second(test_settings());
  const auto bullets = GetParam().second(std::nullopt);
  ours->step(kStep);
  bullets->step(kStep);
  const auto their_contacts = contacts_of(bullets->world().getSoftBodyArray());
  std::size_t compared = 0;
  for (const auto& [pair, our] : contacts_of(ours->world().getSoftBodyArray())) {
    const auto their = their_contacts.find(pair);
    if (their == their_contacts.end()) continue;
    ++compared;
    EXPECT_LT(our.m_bary.distance(their->second.m_bary), btScalar(1e-4));
    EXPECT_LT(our.m_normal.distance(their->second.m_normal), btScalar(1e-5));
    EXPECT_EQ(our.m_margin, their->second.m_margin);
    EXPECT_EQ(our.m_friction, their->second.m_friction);
  }
  EXPECT_GT(compared, 1000U);
}

}  // namespace
}  // namespace softcd::test
