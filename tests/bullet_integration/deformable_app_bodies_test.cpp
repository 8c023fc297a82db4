// Everything that an app can set on its bodies in the deformable world while the simulation runs, compared with
// Bullet's own result.

#include <gtest/gtest.h>

#include <limits>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "deformable_app_support.hpp"

namespace softcd::test {
namespace {

using Flags = btSoftBody::fCollision;

TEST(DeformableAppBodies, vertex_face_contacts_can_be_switched_off_and_on) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    Steps steps = {sheets.step()};
    sheets.lower.m_cfg.collisions &= ~Flags::VF_DD;
    steps.push_back(sheets.step());
    sheets.lower.m_cfg.collisions |= Flags::VF_DD;
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {true, false, true});
}

TEST(DeformableAppBodies, self_collision_can_be_switched_on_and_off) {
  const auto run = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    btSoftBody& roll = sheets.add(make_roll(sheets.simulation().world_info(), 40, 4));
    Steps steps;
    for (const bool collides : {false, true, false, true}) {
      roll.setSelfCollision(collides);
      steps.push_back(sheets.step());
    }
    return steps;
  };
  expect_steps_as_bullets(run, {false, true, false, true});
}

TEST(DeformableAppBodies, self_collision_may_be_everybodys_or_nobodys) {
  using bullet::SelfCollision;
  HeldSheets sheets(cpu_settings());
  btSoftBody& roll = sheets.add(make_roll(sheets.simulation().world_info(), 40, 4));
  roll.setSelfCollision(true);
  const NodeFaceSet flagged = sheets.step();
  EXPECT_FALSE(flagged.empty());
  for (const bool flag : {false, true}) {
    roll.setSelfCollision(flag);
    for (const SelfCollision self_collision : {SelfCollision::all, SelfCollision::none}) {
      bullet::Settings settings = cpu_settings();
      settings.self_collision = self_collision;
      sheets.simulation().detection()->set_settings(settings);
      EXPECT_EQ(sheets.step(), self_collision == SelfCollision::all ? flagged : NodeFaceSet());
    }
  }
}

TEST(DeformableAppBodies, flags_beside_vertex_face_contacts_mean_what_they_mean_to_bullet) {
  for (const int beside : {Flags::CL_SELF, Flags::VF_SS}) {
    const auto within = [&](const MaybeSettings& settings) {
      HeldSheets sheets(settings);
      btSoftBody& roll = sheets.add(make_roll(sheets.simulation().world_info(), 40, 4));
      roll.setSelfCollision(true);
      Steps steps = {sheets.step()};
      roll.m_cfg.collisions |= beside;
      steps.push_back(sheets.step());
      return steps;
    };
    expect_steps_as_bullets(within, {true, false});
    const auto between = [&](const MaybeSettings& settings) {
      TwoHeldSheets sheets(settings);
      Steps steps;
      for (btSoftBody* body : {&sheets.lower, &sheets.upper}) {
        body->m_cfg.collisions |= beside;
        steps.push_back(sheets.step());
      }
      return steps;
    };
    expect_steps_as_bullets(between, {true, false});
  }
}

void ignore_everything(btBroadphasePair& /*pair*/, btCollisionDispatcher& /*dispatcher*/,
                       const btDispatcherInfo& /*info*/) {}

/// Sheets of which some filter says that they do not collide; without filters, then, and again with them.
Steps filtered(MaybeSettings settings, bool filters, const std::function<void(TwoHeldSheets&, bool)>& forbid,
               int mask = -1) {
  if (settings.has_value()) settings->filter_deformables = filters;
  TwoHeldSheets sheets(settings, 1, mask);
  Steps steps;
  for (const bool is_forbidden : {true, false, true}) {
    forbid(sheets, is_forbidden);
    steps.push_back(sheets.step());
  }
  return steps;
}

TEST(DeformableAppBodies, filters_decide_about_pairs_where_asked_to_and_as_with_bullet_where_not) {
  const auto masks = [](TwoHeldSheets& sheets, bool is_forbidden) {
    sheets.lower.getBroadphaseHandle()->m_collisionFilterMask = is_forbidden ? 2 : -1;
  };
  const auto ignored_pair = [](TwoHeldSheets& sheets, bool is_forbidden) {
    sheets.lower.setIgnoreCollisionCheck(&sheets.upper, is_forbidden);
    sheets.upper.setIgnoreCollisionCheck(&sheets.lower, is_forbidden);
  };
  const auto near_callback = [](TwoHeldSheets& sheets, bool is_forbidden) {
    auto* dispatcher = static_cast<btCollisionDispatcher*>(sheets.simulation().world().getDispatcher());
    dispatcher->setNearCallback(is_forbidden ? ignore_everything : btCollisionDispatcher::defaultNearCallback);
  };
  for (const auto& forbid :
       std::vector<std::function<void(TwoHeldSheets&, bool)>>{masks, ignored_pair, near_callback}) {
    const NodeFaceSet all = filtered(std::nullopt, false, forbid)[0];
    EXPECT_FALSE(all.empty()) << "Bullet asks nobody";
    EXPECT_EQ(filtered(cpu_settings(), false, forbid), (Steps{all, all, all}));
    EXPECT_EQ(filtered(cpu_settings(), true, forbid), (Steps{{}, all, {}}));
  }
  const auto nothing = [](TwoHeldSheets&, bool) {};
  EXPECT_EQ(filtered(cpu_settings(), true, nothing, /*mask=*/2), (Steps{{}, {}, {}}));
}

TEST(DeformableAppBodies, margins_count_as_they_are_in_the_step) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    Steps steps;
    for (const double margin : {0.02, 0.01, 0.025}) {
      sheets.upper.getCollisionShape()->setMargin(btScalar(margin));
      sheets.lower.getCollisionShape()->setMargin(btScalar(margin));
      steps.push_back(sheets.step());
    }
    return steps;
  };
  expect_steps_as_bullets(run, {true, false, true});
}

TEST(DeformableAppBodies, sleepers_get_no_contacts_and_bullets_pile_up) {
  const auto counts = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    // Bodies whose filters let them overlap wake each other.
    const btSoftBody& awake = sheets.add(0, 1, 1);
    btSoftBody& sleeper = sheets.add(btScalar(0.015), 2, 2);
    sheets.step();
    std::vector<int> result = {sleeper.m_faceNodeContacts.size()};
    sleeper.forceActivationState(ISLAND_SLEEPING);
    for (int step = 0; step < 3; ++step) sheets.step();
    EXPECT_FALSE(sleeper.isActive());
    EXPECT_GT(awake.m_faceNodeContacts.size(), 0) << "its own contacts with the sleeper's faces";
    result.push_back(sleeper.m_faceNodeContacts.size());
    sleeper.activate(/*forceActivation=*/true);
    sheets.step();
    result.push_back(sleeper.m_faceNodeContacts.size());
    return result;
  };
  const std::vector<int> ours = counts(cpu_settings());
  EXPECT_GT(ours[0], 0);
  EXPECT_EQ(ours, std::vector<int>(3, ours[0]));
  EXPECT_GT(counts(std::nullopt)[1], ours[0]);
}

TEST(DeformableAppBodies, an_active_neighbour_wakes_a_sleeper) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    for (btSoftBody* body : {&sheets.lower, &sheets.upper}) body->forceActivationState(ISLAND_SLEEPING);
    Steps steps = {sheets.step()};
    sheets.lower.activate(/*forceActivation=*/true);
    sheets.step();
    EXPECT_TRUE(sheets.upper.isActive());
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {false, true});
}

TEST(DeformableAppBodies, a_body_at_rest_falls_asleep) {
  for (const MaybeSettings& settings : {MaybeSettings(), MaybeSettings(cpu_settings())}) {
    HeldSheets sheets(settings);
    const btSoftBody& sheet =
        sheets.add(make_small_sheet(sheets.simulation().world_info(), /*height=*/0, /*fixed=*/true));
    for (int step = 0; step < 100; ++step) sheets.step();
    EXPECT_TRUE(sheet.isActive());
    for (int step = 0; step < 30; ++step) sheets.step();
    EXPECT_FALSE(sheet.isActive()) << "after more than two seconds";
  }
}

TEST(DeformableAppBodies, nodes_may_lose_their_mass_and_get_it_back) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    Steps steps = {sheets.step()};
    for (const int mass : {0, 1}) {
      for (btSoftBody* body : {&sheets.lower, &sheets.upper}) {
        for (int n = 0; n < body->m_nodes.size(); ++n) body->setMass(n, btScalar(mass));
      }
      steps.push_back(sheets.step());
    }
    sheets.lower.setTotalMass(50);
    steps.push_back(sheets.step());
    for (int n = 0; n < 40; ++n) sheets.upper.setMass(n, 0);
    for (int n = 0; n < sheets.lower.m_nodes.size(); ++n) sheets.lower.setMass(n, 0);
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {true, false, true, true, true});
}

/// A cloth on a sheet without mass.
struct LyingCloth {
  demo::DeformableSimulation simulation;
  btSoftBody* sheet;
  btSoftBody* cloth;

  explicit LyingCloth(const MaybeSettings& settings) : simulation(settings) {
    SheetOptions options;
    options.margin = btScalar(0.02);
    options.fixed = true;
    options.side = btScalar(1.2);
    sheet = &simulation.add(make_sheet(simulation.world_info(), options));
    options.fixed = false;
    options.side = btScalar(0.8);
    options.height = btScalar(0.045);
    cloth = &simulation.add(make_sheet(simulation.world_info(), options));
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) simulation.step(kShortStep);
  }
  btScalar gap() const { return mean_height(*cloth) - mean_height(*sheet); }
};

void expect_gap_as_bullets(const std::function<btScalar(const MaybeSettings&)>& gap) {
  EXPECT_NEAR(double(gap(cpu_settings())), double(gap(std::nullopt)), 0.01);
  EXPECT_GT(gap(cpu_settings()), 0.01);
}

TEST(DeformableAppBodies, a_sheet_moved_by_the_app_carries_the_cloth_along) {
  expect_gap_as_bullets([](const MaybeSettings& settings) {
    LyingCloth scene(settings);
    for (int n = 0; n < scene.sheet->m_nodes.size(); ++n) scene.sheet->m_nodes[n].m_v = btVector3(0, 1, 0);
    scene.run(120);
    EXPECT_NEAR(double(mean_height(*scene.sheet)), 0.5, 1e-3);
    return scene.gap();
  });
}

TEST(DeformableAppBodies, a_cloth_that_becomes_heavy_stays_on_the_sheet) {
  expect_gap_as_bullets([](const MaybeSettings& settings) {
    LyingCloth scene(settings);
    scene.run(60);
    scene.cloth->setTotalMass(3);
    scene.run(60);
    return scene.gap();
  });
}

TEST(DeformableAppBodies, a_rope_and_a_single_node_collide_as_points) {
  const auto run = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    sheets.add(0);
    btSoftBodyWorldInfo& info = sheets.simulation().world_info();
    const btVector3 left(btScalar(-0.4), btScalar(0.02), btScalar(0.01));
    const btVector3 right(btScalar(0.4), btScalar(0.02), btScalar(0.01));
    std::unique_ptr<btSoftBody> rope(btSoftBodyHelpers::CreateRope(info, left, right, 12, 0));
    rope->getCollisionShape()->setMargin(btScalar(0.02));
    sheets.add(std::move(rope));
    auto single = std::make_unique<btSoftBody>(&info, 1, &left, nullptr);
    single->getCollisionShape()->setMargin(btScalar(0.02));
    sheets.add(std::move(single));
    Steps steps = {sheets.step()};
    EXPECT_EQ(sheets.bodies()[0]->m_faceNodeContacts.size(), 0) << "the sheet's nodes have no faces to touch";
    EXPECT_GT(sheets.bodies()[1]->m_faceNodeContacts.size(), 0);
    EXPECT_GT(sheets.bodies()[2]->m_faceNodeContacts.size(), 0);
    return steps;
  };
  expect_steps_as_bullets(run, {true});
}

TEST(DeformableAppBodies, a_position_that_is_no_number_is_reported_and_harms_nobody_elses_contacts) {
  bullet::Settings settings = cpu_settings();
  std::vector<std::string> warnings;
  settings.log = [&](LogLevel level, std::string_view message) {
    if (level == LogLevel::warning) warnings.emplace_back(message);
  };
  TwoHeldSheets sheets(settings);
  SheetOptions options;
  options.height = btScalar(0.06);
  options.margin = btScalar(0.02);
  auto spoilt = make_sheet(sheets.simulation().world_info(), options);
  spoilt->m_nodes[0].m_x.setY(std::numeric_limits<btScalar>::quiet_NaN());
  btSoftBody& body = sheets.add(std::move(spoilt));
  const NodeFaceSet contacts = sheets.step();
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("not finite"), std::string::npos) << warnings[0];
  sheets.remove(body);
  TwoHeldSheets without(cpu_settings());
  const NodeFaceSet expected = without.step();
  EXPECT_TRUE(std::includes(contacts.begin(), contacts.end(), expected.begin(), expected.end()));
  EXPECT_GT(contacts.size(), expected.size()) << "with the rest of the spoilt one";
}

TEST(DeformableAppBodies, others_go_on_beside_a_body_whose_positions_are_no_numbers) {
  expect_gap_as_bullets([](const MaybeSettings& settings) {
    LyingCloth scene(settings);
    btSoftBody& spoilt = scene.simulation.add(make_small_sheet(scene.simulation.world_info(), btScalar(0.1)));
    spoilt.m_nodes[0].m_x.setY(std::numeric_limits<btScalar>::quiet_NaN());
    scene.run(40);
    return scene.gap();
  });
}

}  // namespace
}  // namespace softcd::test
