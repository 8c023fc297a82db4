// Bodies with few contacts rest like those with all contacts of Bullet's rule.

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "any_simulation.hpp"
#include "scenes/soft_ball.hpp"
#include "still_sheets.hpp"

namespace softcd::test {
namespace {

/// A sheet above a fixed one.
struct TwoSheets {
  TwoSheets(World world, Contacts given, btScalar height) : simulation(world, settings_choosing(given)) {
    SheetOptions options;
    options.fixed = true;
    options.margin = btScalar(0.03);
    fixed = &simulation.add(make_sheet(simulation.world_info(), options));
    options.fixed = false;
    options.side = btScalar(0.9);
    options.height = height;
    free = &simulation.add(make_sheet(simulation.world_info(), options));
    steps_of_a_second = static_cast<int>(1 / simulation.step_length());
  }

  AnySimulation simulation;
  btSoftBody *fixed, *free;
  int steps_of_a_second;
};

/// Mean gap, and contacts, of a sheet that has come to rest on a fixed one after a second.
std::pair<btScalar, std::size_t> rest(World world, Contacts given, btScalar height = btScalar(0.08)) {
  TwoSheets sheets(world, given, height);
  btScalar sum = 0;
  std::size_t contacts = 0;
  const int steps = sheets.steps_of_a_second;
  const int steps_to_rest = steps * 3 / 4;
  for (int i = 0; i < steps; ++i) {
    sheets.simulation.step_once();
    if (i >= steps_to_rest) sum += mean_height(*sheets.free);
    contacts += static_cast<std::size_t>(sheets.free->m_scontacts.size() + sheets.free->m_faceNodeContacts.size());
  }
  return {sum / btScalar(steps - steps_to_rest), contacts};
}

/// Returns the greatest mean height of a resting sheet within half a second after both margins have grown.
btScalar thrown_to(World world, Contacts given) {
  TwoSheets sheets(world, given, btScalar(0.08));
  for (int i = 0; i < sheets.steps_of_a_second; ++i) sheets.simulation.step_once();
  for (btSoftBody* sheet : {sheets.fixed, sheets.free}) sheet->getCollisionShape()->setMargin(btScalar(0.15));
  btScalar highest = 0;
  for (int i = 0; i < sheets.steps_of_a_second / 2; ++i) {
    sheets.simulation.step_once();
    highest = btMax(highest, mean_height(*sheets.free));
  }
  return highest;
}

void expect_same_rest(World world) {
  const auto all = rest(world, Contacts::all);
  const auto chosen = rest(world, Contacts::closest_feature);
  EXPECT_NEAR(double(chosen.first), double(all.first), 0.02 * double(all.first));
  EXPECT_LE(chosen.second, all.second / 2);
}

TEST(ContactEconomy, a_sheet_rests_as_high_in_the_classic_world) {
  expect_same_rest(World::one_line);
}

/// Bullet's classic margins let no node lie still, and where the hops of a second end depends on every bit of the
/// start. Without the cut of joint_margin the mean of these starts is 1.6 % higher than with all contacts.
TEST(ContactEconomy, sheets_rest_as_high_on_average_in_the_classic_world) {
  double all_sum = 0, chosen_sum = 0;
  for (int start = 0; start < 12; ++start) {
    const btScalar height = btScalar(0.08) + btScalar(start) * btScalar(0.001);
    all_sum += double(rest(World::one_line, Contacts::all, height).first);
    chosen_sum += double(rest(World::one_line, Contacts::closest_feature, height).first);
  }
  EXPECT_NEAR(chosen_sum, all_sum, 0.01 * all_sum);
}

TEST(ContactEconomy, a_sheet_rests_as_high_in_the_deformable_world) {
  expect_same_rest(World::deformable);
}

/// The contact with the pushes of all would throw the sheet several times as high.
TEST(ContactEconomy, margins_that_grow_throw_a_sheet_no_higher_in_the_deformable_world) {
  EXPECT_LE(thrown_to(World::deformable, Contacts::closest_feature), thrown_to(World::deformable, Contacts::all));
}

/// With all contacts of edges a ball's flat sides held each other: each step gave Bullet's solver some hundred contacts
/// a node, and the balls stayed flat.
TEST(ContactEconomy, balls_that_fall_on_each_other_have_few_contacts_with_safe) {
  bullet::Settings settings = bullet::Settings::safe();
  settings.backend = backend_under_test();
  demo::SoftWorld world(demo::World::classic, PlugIn::one_line_world, settings);
  world.add_rigid(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  constexpr int kBalls = 8;
  std::size_t nodes = 0, most = 0;
  for (int i = 0; i < kBalls; ++i) {
    const btScalar shift = btScalar(0.05) * btScalar(i % 3);
    const btVector3 center(shift, btScalar(0.4) + btScalar(0.65) * btScalar(i), btScalar(0.1) - shift);
    btSoftBody& ball = world.add(demo::make_soft_ball(world, {center, btScalar(0.3), 2, 1, btScalar(0.03)}));
    ball.m_cfg.piterations = 4;
    nodes += static_cast<std::size_t>(ball.m_nodes.size());
  }
  for (int i = 0; i < 60; ++i) {
    world.step();
    most = std::max(most, world.count_soft_contacts());
  }
  EXPECT_GT(most, 0U);
  EXPECT_LT(most, 10 * nodes);
}

}  // namespace
}  // namespace softcd::test
