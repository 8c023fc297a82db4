// Bullet's own trees and flags, whose cost softcd avoids.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

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

}  // namespace
}  // namespace softcd::test
