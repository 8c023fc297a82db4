// Bad input from an app, by mistake or on purpose: nothing hangs, and other bodies are not affected.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "any_simulation.hpp"
#include "scenes/penetration.hpp"
#include "small_scenes.hpp"

namespace softcd::test {
namespace {

constexpr btScalar kNotANumber = std::numeric_limits<btScalar>::quiet_NaN();

class BadInput : public testing::TestWithParam<World> {
 protected:
  BadInput() : simulation(GetParam(), settings()) {}

  bullet::Settings settings() {
    bullet::Settings settings = careful_settings();
    settings.self_collision = bullet::SelfCollision::all;
    settings.log = [this](LogLevel level, std::string_view text) {
      // A dispatcher gives this warning for any input.
      const bool is_of_dispatcher = text.find("softcd::bullet::Dispatcher") != std::string_view::npos;
      if (level == LogLevel::warning && !is_of_dispatcher) warnings.emplace_back(text);
    };
    return settings;
  }

  std::unique_ptr<btSoftBody> make_at(btScalar height, bool fixed = false) {
    SheetOptions options;
    options.nodes_per_side = 5;
    options.height = height;
    options.margin = btScalar(0.02);
    options.fixed = fixed;
    return make_sheet(simulation.world_info(), options);
  }

  /// A held sheet with one that falls onto it.
  void add_good_ones() {
    good = {&simulation.add(make_at(0, /*fixed=*/true)), &simulation.add(make_at(btScalar(0.1)))};
  }
  void expect_good_ones_unharmed() const {
    for (const btSoftBody* body : good) {
      for (const btScalar x : coordinates_of(*body)) EXPECT_TRUE(std::isfinite(x));
    }
    EXPECT_EQ(demo::find_intersections({good.begin(), good.end()}).edge_count, 0U);
  }
  void step(int count) {
    for (int i = 0; i < count; ++i) simulation.step();
  }

  AnySimulation simulation;
  std::vector<const btSoftBody*> good;
  std::vector<std::string> warnings;
};
INSTANTIATE_TEST_SUITE_P(Worlds, BadInput, kWorldsOfRun, world_name);

TEST_P(BadInput, velocities_that_are_no_numbers_stay_with_their_body) {
  add_good_ones();
  btSoftBody& spoilt = simulation.add(make_at(btScalar(0.2)));
  step(1);
  spoilt.m_nodes[7].m_v = btVector3(0, kNotANumber, 0);
  step(10);
  EXPECT_TRUE(std::isnan(spoilt.m_nodes[7].m_x.y()));
  expect_good_ones_unharmed();
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("not finite"), std::string::npos) << warnings[0];
}

TEST_P(BadInput, velocities_that_are_no_numbers_stay_with_a_body_that_touches_others) {
  add_good_ones();
  btSoftBody& spoilt = simulation.add(make_at(btScalar(0.12)));
  step(5);
  for (int n = 0; n < 5; ++n) spoilt.m_nodes[n].m_v = btVector3(kNotANumber, 0, 0);
  step(10);
  expect_good_ones_unharmed();
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("not finite"), std::string::npos) << warnings[0];
}

TEST_P(BadInput, margins_that_are_no_numbers_stay_with_their_body) {
  add_good_ones();
  btSoftBody& spoilt = simulation.add(make_at(btScalar(0.12)));
  step(1);
  spoilt.setVelocity(btVector3(0, -3, 0));
  spoilt.getCollisionShape()->setMargin(kNotANumber);
  step(10);
  expect_good_ones_unharmed();
}

TEST_P(BadInput, velocities_beyond_all_bounds_stay_with_their_body) {
  add_good_ones();
  btSoftBody& thrown = simulation.add(make_at(btScalar(0.3)));
  step(1);
  thrown.m_nodes[3].m_v = btVector3(0, btScalar(1e30), 0);
  step(10);
  expect_good_ones_unharmed();
}

TEST_P(BadInput, bodies_all_of_whose_nodes_are_fixed_hold_what_falls_onto_them) {
  add_good_ones();
  const std::vector<btScalar> before = coordinates_of(*good[0]);
  btSoftBody& thrown = simulation.add(make_at(btScalar(0.5)));
  thrown.setVelocity(btVector3(0, -50, 0));
  step(10);
  expect_good_ones_unharmed();
  EXPECT_EQ(coordinates_of(*good[0]), before);
  EXPECT_TRUE(warnings.empty());
}

TEST_P(BadInput, bodies_without_mass_pass_through_each_other_unanswered) {
  add_good_ones();
  btSoftBody& first = simulation.add(make_at(2, /*fixed=*/true));
  btSoftBody& second = simulation.add(make_at(btScalar(2.2), /*fixed=*/true));
  for (int n = 0; n < second.m_nodes.size(); ++n) second.m_nodes[n].m_v = btVector3(0, -30, 0);
  step(4);
  EXPECT_LT(second.m_nodes[0].m_x.y(), first.m_nodes[0].m_x.y());
  expect_good_ones_unharmed();
}

TEST_P(BadInput, bodies_of_a_node_and_of_none_are_let_be) {
  add_good_ones();
  const btVector3 place(0, btScalar(0.3), 0);
  btSoftBody& single = simulation.add(std::make_unique<btSoftBody>(&simulation.world_info(), 1, &place, nullptr));
  single.m_nodes[0].m_v = btVector3(0, -100, 0);
  simulation.add(std::make_unique<btSoftBody>(&simulation.world_info(), 0, nullptr, nullptr));
  step(10);
  expect_good_ones_unharmed();
  EXPECT_TRUE(warnings.empty());
}

TEST_P(BadInput, steps_of_no_time_and_of_ten_seconds_end) {
  add_good_ones();
  simulation.step(0);
  step(1);
  if (GetParam() != World::dispatcher) simulation.step(10);  // which prevents no crossings
  simulation.step(0);
  step(5);
  expect_good_ones_unharmed();
}

TEST_P(BadInput, nodes_in_one_place_are_let_be) {
  add_good_ones();
  btSoftBody& collapsed = simulation.add(make_at(btScalar(0.3)));
  for (int n = 0; n < collapsed.m_nodes.size(); ++n) collapsed.m_nodes[n].m_x = btVector3(0, btScalar(0.3), 0);
  step(5);
  for (const btSoftBody* body : good) {
    for (const btScalar x : coordinates_of(*body)) EXPECT_TRUE(std::isfinite(x));
  }
}

}  // namespace
}  // namespace softcd::test
