// Everything that an app can set to say which bodies collide.

#include <gtest/gtest.h>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "small_scenes.hpp"

namespace softcd::test {
namespace {

using demo::PlugIn;
using demo::Simulation;
using Flags = btSoftBody::fCollision;

class Filter : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, Filter, testing::ValuesIn(kPlugIns), plug_in_name);

TEST_P(Filter, none_lets_the_pair_collide) {
  TwoSheets sheets(GetParam());
  sheets.add();
  EXPECT_GT(sheets.step(), 0);
}

TEST_P(Filter, group_and_mask_must_agree_both_ways) {
  TwoSheets agreeing(GetParam());
  agreeing.add(/*group_a=*/2, /*mask_a=*/4, /*group_b=*/4, /*mask_b=*/2);
  EXPECT_GT(agreeing.step(), 0);
  TwoSheets one_sided(GetParam());
  one_sided.add(/*group_a=*/2, /*mask_a=*/4, /*group_b=*/4, /*mask_b=*/1);
  EXPECT_EQ(one_sided.step(), 0);
}

TEST_P(Filter, ignored_pairs_are_left_out_while_ignored) {
  TwoSheets sheets(GetParam());
  sheets.add();
  sheets.lower().setIgnoreCollisionCheck(&sheets.upper(), true);
  EXPECT_EQ(sheets.step(), 0);
  sheets.lower().setIgnoreCollisionCheck(&sheets.upper(), false);
  EXPECT_GT(sheets.step(), 0);
}

TEST_P(Filter, overlap_filter_callback_replaces_groups_and_masks) {
  struct Callback : btOverlapFilterCallback {
    bool answer = false;
    bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override { return answer; }
  } callback;
  TwoSheets refused(GetParam());
  refused.pair_cache().setOverlapFilterCallback(&callback);
  refused.add();
  EXPECT_EQ(refused.step(), 0);
  callback.answer = true;
  TwoSheets allowed(GetParam());
  allowed.pair_cache().setOverlapFilterCallback(&callback);
  allowed.add(/*group_a=*/2, /*mask_a=*/2, /*group_b=*/4, /*mask_b=*/4);
  EXPECT_GT(allowed.step(), 0);
}

int near_callback_calls_with_rigid = 0;

void refuse_soft_pairs(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  const auto is_soft = [](const btBroadphaseProxy* proxy) {
    return btSoftBody::upcast(static_cast<const btCollisionObject*>(proxy->m_clientObject)) != nullptr;
  };
  if (is_soft(pair.m_pProxy0) && is_soft(pair.m_pProxy1)) return;
  ++near_callback_calls_with_rigid;
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
}

TEST_P(Filter, near_callback_is_asked) {
  TwoSheets sheets(GetParam());
  sheets.add();
  sheets.simulation().add_static_box(btVector3(1, 1, 1), btVector3(0, -1, 0));
  sheets.simulation().dispatcher().setNearCallback(refuse_soft_pairs);
  near_callback_calls_with_rigid = 0;
  EXPECT_EQ(sheets.step(), 0);
  EXPECT_EQ(near_callback_calls_with_rigid, 2);
  EXPECT_GT(sheets.lower().m_rcontacts.size(), 0);
  sheets.simulation().dispatcher().setNearCallback(btCollisionDispatcher::defaultNearCallback);
  EXPECT_GT(sheets.step(), 0);
}

TEST_P(Filter, vertex_face_flag_is_needed_on_both_and_can_change_at_run_time) {
  TwoSheets sheets(GetParam());
  sheets.add();
  EXPECT_GT(sheets.step(), 0);
  sheets.lower().m_cfg.collisions = Flags::SDF_RS;
  EXPECT_EQ(sheets.step(), 0);
  sheets.lower().m_cfg.collisions |= Flags::VF_SS;
  EXPECT_GT(sheets.step(), 0);
}

TEST_P(Filter, margins_are_read_in_every_step) {
  TwoSheets sheets(GetParam());
  sheets.add();
  EXPECT_GT(sheets.step(), 0);
  sheets.lower().getCollisionShape()->setMargin(btScalar(0.002));
  sheets.upper().getCollisionShape()->setMargin(btScalar(0.002));
  EXPECT_EQ(sheets.step(), 0);
  sheets.upper().getCollisionShape()->setMargin(btScalar(0.04));
  EXPECT_GT(sheets.step(), 0);
}

// Bullet clears a body's contacts in its prediction, which leaves inactive bodies out. (A body that merely sleeps is
// woken by an active neighbour.)
TEST_P(Filter, inactive_bodies_get_no_contacts) {
  TwoSheets sheets(GetParam());
  sheets.add();
  sheets.lower().forceActivationState(DISABLE_SIMULATION);
  for (int i = 0; i < 3; ++i) {
    sheets.step();
    EXPECT_EQ(sheets.lower().m_scontacts.size(), 0);
    EXPECT_GT(sheets.upper().m_scontacts.size(), 0);
  }
  sheets.upper().forceActivationState(DISABLE_SIMULATION);
  const int before = sheets.upper().m_scontacts.size();
  for (int i = 0; i < 3; ++i) sheets.step();
  EXPECT_EQ(sheets.upper().m_scontacts.size(), before);
  sheets.lower().forceActivationState(ACTIVE_TAG);
  sheets.step();
  EXPECT_GT(sheets.lower().m_scontacts.size(), 0);
}

TEST_P(Filter, bodies_whose_nodes_are_all_fixed_never_touch_each_other) {
  TwoSheets sheets(GetParam());
  sheets.add();
  for (btSoftBody* body : {&sheets.lower(), &sheets.upper()}) {
    for (int i = 0; i < body->m_nodes.size(); ++i) body->setMass(i, 0);
  }
  EXPECT_EQ(sheets.step(), 0);
  EXPECT_EQ(sheets.simulation().detection()->contact_report().statistics().vt_contacts, 0U);
  sheets.upper().setMass(0, 1);
  EXPECT_GT(sheets.step(), 0);
}

/// A sheet folded onto itself.
int self_contacts(PlugIn plug_in, bullet::SelfCollision self_collision, bool is_flagged) {
  bullet::Settings settings = test_settings();
  settings.self_collision = self_collision;
  Simulation simulation(plug_in, settings);
  SheetOptions options;
  options.margin = btScalar(0.02);
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  sheet.setSelfCollision(is_flagged);
  sheet.m_cfg.piterations = 0;
  for (int i = 0; i < sheet.m_nodes.size(); ++i) {
    btVector3& x = sheet.m_nodes[i].m_x;
    if (x.x() > 0) x = btVector3(-x.x(), btScalar(0.03), x.z());
  }
  simulation.step(kStep);
  return sheet.m_scontacts.size();
}

TEST_P(Filter, self_collision_follows_the_flag_or_the_setting) {
  using bullet::SelfCollision;
  EXPECT_GT(self_contacts(GetParam(), SelfCollision::flagged, true), 0);
  EXPECT_EQ(self_contacts(GetParam(), SelfCollision::flagged, false), 0);
  EXPECT_GT(self_contacts(GetParam(), SelfCollision::all, false), 0);
  EXPECT_EQ(self_contacts(GetParam(), SelfCollision::none, true), 0);
}

/// Returns the node positions of two overlapping clustered balls some steps later.
std::vector<btScalar> after_cluster_collision(PlugIn plug_in, int flags) {
  Simulation simulation(plug_in, test_settings());
  simulation.world_info().m_gravity.setZero();
  std::vector<btScalar> positions;
  btSoftBody* bodies[2];
  for (int b = 0; b < 2; ++b) {
    auto ball =
        demo::make_ball(simulation.world_info(), btVector3(btScalar(b) * btScalar(0.9), 0, 0), btScalar(0.5), 2);
    ball->setTotalMass(1, /*fromfaces=*/true);
    ball->generateClusters(8);
    ball->m_cfg.collisions = flags;
    bodies[b] = &simulation.add(std::move(ball));
  }
  for (int step = 0; step < 5; ++step) simulation.step(kStep);
  for (const btSoftBody* body : bodies) {
    for (int i = 0; i < body->m_nodes.size(); ++i) positions.push_back(body->m_nodes[i].m_x.x());
  }
  return positions;
}

TEST_P(Filter, cluster_collision_stays_bullets) {
  for (const int flags :
       {int(Flags::CL_SS), Flags::CL_SS | Flags::CL_RS, Flags::CL_SS | Flags::VF_SS, Flags::VF_SS | Flags::CL_SELF}) {
    EXPECT_EQ(after_cluster_collision(GetParam(), flags), after_cluster_collision(PlugIn::none, flags))
        << "flags " << flags;
  }
  EXPECT_NE(after_cluster_collision(GetParam(), Flags::CL_SS), after_cluster_collision(GetParam(), 0));
}

}  // namespace
}  // namespace softcd::test
