// Bullet's own trees and flags, whose cost softcd avoids.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using demo::PlugIn;
using demo::Simulation;
using Flags = btSoftBody::fCollision;

class NativeTrees : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, NativeTrees, testing::ValuesIn(kPlugIns), plug_in_name);

TEST_P(NativeTrees, no_face_tree_is_built_and_flags_are_given_back) {
  Simulation simulation(GetParam(), cpu_settings());
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), {}));
  const int flags = Flags::SDF_RS | Flags::VF_SS;
  for (int step = 0; step < 3; ++step) {
    simulation.step(kStep);
    EXPECT_EQ(sheet.m_cfg.collisions, flags);
    EXPECT_TRUE(sheet.m_fdbvt.empty());
  }
}

TEST_P(NativeTrees, flags_assigned_before_the_first_step_stand) {
  Simulation simulation(GetParam(), cpu_settings());
  btSoftBody& cleared = simulation.add(make_sheet(simulation.world_info(), {}));
  cleared.m_cfg.collisions = Flags::SDF_RS;
  btSoftBody& added_to = simulation.add(make_sheet(simulation.world_info(), {}));
  added_to.m_cfg.collisions |= Flags::CL_RS;
  btSoftBody& set = simulation.add(make_sheet(simulation.world_info(), {}));
  set.m_cfg.collisions = Flags::VF_SS;
  simulation.step(kStep);
  EXPECT_EQ(cleared.m_cfg.collisions, Flags::SDF_RS);
  EXPECT_EQ(added_to.m_cfg.collisions, Flags::SDF_RS | Flags::VF_SS | Flags::CL_RS);
  EXPECT_EQ(set.m_cfg.collisions, Flags::VF_SS);
  EXPECT_TRUE(set.m_fdbvt.empty());
}

TEST_P(NativeTrees, flags_are_given_back_to_a_body_removed_before_its_first_step) {
  Simulation simulation(GetParam(), cpu_settings());
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), {}));
  const auto removed = simulation.remove(sheet);
  EXPECT_EQ(removed->m_cfg.collisions, Flags::SDF_RS | Flags::VF_SS);
}

// A ray test builds a face tree if there is none. If softcd removed it in every step, each ray test would build one.
TEST_P(NativeTrees, ray_tests_hit_and_soon_keep_their_tree) {
  Simulation simulation(GetParam(), cpu_settings());
  simulation.world_info().m_gravity.setZero();
  btSoftBody& lower = simulation.add(make_sheet(simulation.world_info(), {}));
  SheetOptions options;
  options.height = btScalar(0.03);
  btSoftBody& upper = simulation.add(make_sheet(simulation.world_info(), options));
  for (int step = 0; step < 4; ++step) {
    simulation.step(kStep);
    const btVector3 x = lower.m_nodes[40].m_x + btVector3(btScalar(0.01), 0, btScalar(0.02));
    btSoftBody::sRayCast hit;
    EXPECT_TRUE(lower.rayTest(x + btVector3(0, 1, 0), x - btVector3(0, 1, 0), hit));
  }
  ASSERT_FALSE(lower.m_fdbvt.empty());
  const btDbvtNode* leaf = lower.m_faces[0].m_leaf;
  simulation.step(kStep);
  ASSERT_FALSE(lower.m_fdbvt.empty());
  EXPECT_EQ(lower.m_faces[0].m_leaf, leaf) << "the tree was built anew";
  // The tree is there, and yet Bullet does not find contacts with its faces a second time.
  std::vector<std::pair<btSoftBody::Node*, btSoftBody::Face*>> contacts;
  contacts.reserve(static_cast<std::size_t>(upper.m_scontacts.size()));
  for (int i = 0; i < upper.m_scontacts.size(); ++i) {
    contacts.emplace_back(upper.m_scontacts[i].m_node, upper.m_scontacts[i].m_face);
  }
  EXPECT_GT(contacts.size(), 0U);
  std::sort(contacts.begin(), contacts.end());
  EXPECT_EQ(std::adjacent_find(contacts.begin(), contacts.end()), contacts.end());
}

TEST_P(NativeTrees, node_leaves_stay_the_nodes_own) {
  Simulation simulation(GetParam(), cpu_settings());
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), {}));
  simulation.step(kStep);
  for (int i = 0; i < sheet.m_nodes.size(); ++i) EXPECT_EQ(sheet.m_nodes[i].m_leaf->data, &sheet.m_nodes[i]);
  EXPECT_EQ(sheet.m_ndbvt.m_leaves, sheet.m_nodes.size());
  sheet.translate(btVector3(1, 2, 3));  // updates every leaf in the tree
  simulation.step(kStep);
  EXPECT_EQ(sheet.m_ndbvt.m_leaves, sheet.m_nodes.size());
}

TEST_P(NativeTrees, a_position_that_is_no_number_harms_nobody_else) {
  Simulation simulation(GetParam(), cpu_settings());
  simulation.world_info().m_gravity.setZero();
  SheetOptions options;
  btSoftBody& lower = simulation.add(make_sheet(simulation.world_info(), options));
  options.height = btScalar(0.03);
  btSoftBody& upper = simulation.add(make_sheet(simulation.world_info(), options));
  for (btSoftBody* body : {&lower, &upper}) body->m_cfg.piterations = 0;
  lower.m_nodes[0].m_x.setY(std::numeric_limits<btScalar>::quiet_NaN());
  simulation.step(kStep);
  EXPECT_GT(upper.m_scontacts.size(), 0);
  for (int i = 0; i < upper.m_scontacts.size(); ++i) {
    for (const btSoftBody::Node* node : upper.m_scontacts[i].m_face->m_n) EXPECT_NE(node, &lower.m_nodes[0]);
  }
}

/// Appends a triangle with links at its sides, which nothing joins to the rest of the body.
void append_part(btSoftBody& body, btScalar x, btScalar height) {
  const int first = body.m_nodes.size();
  const btScalar side = btScalar(0.3);
  for (const btVector3& corner :
       {btVector3(x, height, 0), btVector3(x, height, side), btVector3(x + side, height, 0)}) {
    body.appendNode(corner, btScalar(0.1));
  }
  for (int i = 0; i < 3; ++i) body.appendLink(first + i, first + (i + 1) % 3);
  body.appendFace(first, first + 1, first + 2);
}

/// Ends the program when a step does not end.
class Deadline {
 public:
  Deadline() { alarm(60); }
  ~Deadline() { alarm(0); }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;
};

bool is_hit_from_above(btSoftBody& body, const btSoftBody::Face& face) {
  const btVector3 middle = (face.m_n[0]->m_x + face.m_n[1]->m_x + face.m_n[2]->m_x) / 3;
  btSoftBody::sRayCast hit;
  return body.rayTest(middle + btVector3(0, 1, 0), middle - btVector3(0, 1, 0), hit);
}

// Bullet's construction of a face tree never ends for them. A change of a mass makes its prediction build one.
TEST_P(NativeTrees, steps_end_for_a_body_in_several_parts) {
  const Deadline deadline;
  Simulation simulation(GetParam(), cpu_settings());
  simulation.world_info().m_gravity.setZero();
  SheetOptions options;
  options.fixed = true;
  simulation.add(make_sheet(simulation.world_info(), options));
  auto parts = std::make_unique<btSoftBody>(&simulation.world_info(), 0, nullptr, nullptr);
  parts->m_cfg.collisions = Flags::SDF_RS | Flags::VF_SS;
  parts->getCollisionShape()->setMargin(btScalar(0.05));
  for (const btScalar x : {btScalar(-0.4), btScalar(0.05)}) append_part(*parts, x, btScalar(0.03));
  btSoftBody& body = simulation.add(std::move(parts));
  for (int step = 0; step < 6; ++step) {
    simulation.step(kStep);
    EXPECT_GT(body.m_scontacts.size(), 0) << step;
    EXPECT_EQ(body.m_cfg.collisions & Flags::SDF_RS, Flags::SDF_RS);
    body.setMass(step, btScalar(0.2));
    if (step == 2) append_part(body, btScalar(-0.4), btScalar(0.06));
    // Other worlds leave a body without a tree, which Bullet's ray test of the body then builds.
    if (GetParam() == PlugIn::dispatcher && step == 3) {
      EXPECT_TRUE(is_hit_from_above(body, body.m_faces[2]));
    }
  }
  EXPECT_EQ(simulation.remove(body)->m_cfg.collisions, Flags::SDF_RS | Flags::VF_SS);
}

// From then on Bullet builds its trees again, whose leaves no face may name when they are gone.
TEST_P(NativeTrees, flags_come_back_when_parts_are_joined) {
  const Deadline deadline;
  Simulation simulation(GetParam(), cpu_settings());
  simulation.world_info().m_gravity.setZero();
  auto parts = std::make_unique<btSoftBody>(&simulation.world_info(), 0, nullptr, nullptr);
  parts->m_cfg.collisions = Flags::VF_SS;
  for (const btScalar x : {btScalar(0), btScalar(0.5)}) append_part(*parts, x, 0);
  btSoftBody& body = simulation.add(std::move(parts));
  for (int step = 0; step < 2; ++step) simulation.step(kStep);
  EXPECT_EQ(body.m_cfg.collisions == Flags::VF_SS, GetParam() != PlugIn::dispatcher);
  body.appendLink(2, 3);
  body.appendFace(0, 2, 3);
  body.appendFace(2, 3, 5);
  for (int step = 0; step < 3; ++step) {
    simulation.step(kStep);
    EXPECT_EQ(body.m_cfg.collisions, Flags::VF_SS);
    for (int f = 0; f < body.m_faces.size() && body.m_fdbvt.empty(); ++f) EXPECT_EQ(body.m_faces[f].m_leaf, nullptr);
    body.setMass(0, btScalar(0.2));
  }
}

}  // namespace
}  // namespace softcd::test
