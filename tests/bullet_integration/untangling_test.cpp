// Soft bodies that start through each other, or through themselves, with Settings::untangle.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "attached_worlds.hpp"
#include "scenes/intersecting_bodies.hpp"
#include "scenes/penetration.hpp"

namespace softcd::test {
namespace {

constexpr int kMostSteps = 200;

bullet::Settings untangling(Detection detection, bool untangles = true) {
  bullet::Settings settings = detection == Detection::ccd ? careful_settings() : cpu_settings();
  settings.self_collision = bullet::SelfCollision::all;
  settings.untangle = untangles;
  return settings;
}

/// Intersecting bodies in a world without gravity.
class Tangle {
 public:
  Tangle(const char* name, World world, const bullet::Settings& settings) : simulation_(world, settings) {
    simulation_.set_gravity(btVector3(0, 0, 0));
    const demo::World kind = is_deformable(world) ? demo::World::deformable : demo::World::classic;
    for (auto& body : demo::find_intersecting_bodies(name).make(simulation_.world_info(), kind, 12)) {
      bodies_.push_back(&simulation_.add(std::move(body)));
    }
  }

  void step() {
    simulation_.step();
    double energy = 0;
    for (const btSoftBody* body : bodies_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        const btSoftBody::Node& node = body->m_nodes[n];
        if (!(node.m_im > 0)) continue;
        energy += double(node.m_v.length2() / node.m_im) / 2;
        fastest_ = std::max(fastest_, double(node.m_v.length()));
      }
    }
    energy_ = std::max(energy_, energy);
  }
  /// Returns the number of steps after which nothing intersects, or kMostSteps.
  int steps_until_clean() {
    for (int steps = 1; steps < kMostSteps; ++steps) {
      step();
      if (pairs().empty() && edges() == 0) return steps;
    }
    return kMostSteps;
  }

  AnySimulation& simulation() { return simulation_; }
  const std::vector<bullet::IntersectingBodies>& pairs() { return simulation_.detection().intersecting_bodies(); }
  std::size_t edges() const { return demo::find_intersections(bodies_).edge_count; }
  double fastest() const { return fastest_; }
  double greatest_energy() const { return energy_; }
  double mass() const {
    double mass = 0;
    for (const btSoftBody* body : bodies_) mass += double(body->getTotalMass());
    return mass;
  }
  /// The velocity of the centre of mass.
  double drift() const {
    btVector3 momentum(0, 0, 0);
    double mass = 0;
    for (const btSoftBody* body : bodies_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        const btSoftBody::Node& node = body->m_nodes[n];
        if (!(node.m_im > 0)) continue;
        momentum += node.m_v / node.m_im;
        mass += 1 / double(node.m_im);
      }
    }
    return double(momentum.length()) / mass;
  }

 private:
  AnySimulation simulation_;
  std::vector<const btSoftBody*> bodies_;
  double fastest_ = 0, energy_ = 0;
};

using Parameters = std::tuple<const char*, World, Detection>;

class Untangling : public testing::TestWithParam<Parameters> {};

TEST_P(Untangling, brings_bodies_apart_gently) {
  const auto [name, world, detection] = GetParam();
  Tangle tangle(name, world, untangling(detection));
  const std::size_t edges = tangle.edges();
  ASSERT_GT(edges, 0U);
  const int steps = tangle.steps_until_clean();
  EXPECT_LT(steps, kMostSteps);
  // Springs throw nodes back that the untangling has moved at 1 m/s. The loop's own tension gives it 1.6 J/kg.
  EXPECT_LT(tangle.fastest(), 10);
  EXPECT_LT(tangle.greatest_energy(), tangle.mass() * 3.5);
  if (std::string(name) != "sleeve") {
    EXPECT_LT(tangle.drift(), 0.1);
  }
  if (detection == Detection::dcd) return;
  for (int i = 0; i < 30; ++i) tangle.step();
  EXPECT_EQ(tangle.edges(), 0U) << "the clean pair is guarded again";
}

std::string parameter_name(const testing::TestParamInfo<Parameters>& info) {
  const auto& [name, world, detection] = info.param;
  std::string text = std::string(name) + "_" + name_of(world) + (detection == Detection::ccd ? "_ccd" : "_dcd");
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

INSTANTIATE_TEST_SUITE_P(InEveryWorld, Untangling,
                         testing::Combine(testing::Values("crossed-cloths", "interlocked-cloths", "loop", "two-balls",
                                                          "cloth-in-ball", "sleeve"),
                                          kLookingWorlds, testing::Values(Detection::dcd, Detection::ccd)),
                         parameter_name);
INSTANTIATE_TEST_SUITE_P(Heap, Untangling,
                         testing::Combine(testing::Values("heap"), testing::Values(World::one_line, World::deformable),
                                          testing::Values(Detection::dcd)),
                         parameter_name);

class UntanglingOff : public testing::TestWithParam<std::tuple<const char*, World>> {};

TEST_P(UntanglingOff, leaves_bodies_through_each_other) {
  const auto [name, world] = GetParam();
  Tangle tangle(name, world, untangling(Detection::dcd, /*untangles=*/false));
  for (int i = 0; i < kMostSteps; ++i) tangle.step();
  EXPECT_GT(tangle.edges(), 0U);
  EXPECT_TRUE(tangle.pairs().empty());
}

INSTANTIATE_TEST_SUITE_P(InBothKinds, UntanglingOff,
                         testing::Combine(testing::Values("crossed-cloths", "interlocked-cloths", "two-balls",
                                                          "cloth-in-ball", "sleeve"),
                                          testing::Values(World::one_line, World::deformable)));

TEST(UntanglingReport, counts_regions_lengths_and_steps) {
  Tangle tangle("two-balls", World::one_line, untangling(Detection::dcd));
  tangle.step();
  ASSERT_EQ(tangle.pairs().size(), 1U);
  const bullet::IntersectingBodies first = tangle.pairs()[0];
  EXPECT_EQ(first.a, tangle.simulation().bodies()[0]);
  EXPECT_EQ(first.b, tangle.simulation().bodies()[1]);
  EXPECT_EQ(first.steps, 1U);
  EXPECT_EQ(first.regions, 2U);
  EXPECT_GT(first.curve_length, 0.5);
  for (int i = 0; i < 5; ++i) tangle.step();
  ASSERT_EQ(tangle.pairs().size(), 1U);
  EXPECT_EQ(tangle.pairs()[0].steps, 6U);
  EXPECT_LT(tangle.pairs()[0].curve_length, first.curve_length);
}

TEST(UntanglingReport, says_in_the_log_when_bodies_are_apart) {
  std::string text;
  bullet::Settings settings = untangling(Detection::dcd);
  settings.log = [&](LogLevel, std::string_view message) { text += message; };
  Tangle tangle("two-balls", World::one_line, settings);
  for (int i = 0; i < 60; ++i) tangle.step();
  EXPECT_NE(text.find("untangling: two soft bodies came apart after "), std::string::npos) << text;
}

/// A ball in a balloon may be meant to be there, and nothing says on which side it should come out.
TEST(UntanglingLimits, a_body_wholly_inside_another_one_stays) {
  Tangle tangle("ball-in-ball", World::one_line, untangling(Detection::dcd));
  for (int i = 0; i < 60; ++i) tangle.step();
  EXPECT_TRUE(tangle.pairs().empty());
  EXPECT_LT(tangle.fastest(), 1e-3);
}

TEST(UntanglingLimits, bodies_that_do_not_collide_stay) {
  bullet::Settings settings = untangling(Detection::dcd);
  settings.self_collision = bullet::SelfCollision::none;
  Tangle tangle("loop", World::deformable, settings);
  for (int i = 0; i < 20; ++i) tangle.step();
  EXPECT_TRUE(tangle.pairs().empty());
}

TEST(UntanglingLimits, a_slower_speed_takes_longer) {
  bullet::Settings settings = untangling(Detection::dcd);
  Tangle fast("two-balls", World::one_line, settings);
  settings.untangle_speed = 0.1F;
  Tangle slow("two-balls", World::one_line, settings);
  EXPECT_LT(2 * fast.steps_until_clean(), slow.steps_until_clean());
  EXPECT_LT(slow.fastest(), fast.fastest());
}

TEST(UntanglingLimits, a_speed_out_of_range_is_refused) {
  bullet::Settings settings = untangling(Detection::dcd);
  settings.untangle_speed = 0;
  EXPECT_THROW(AnySimulation(World::one_line, settings), InvalidInput);
}

/// Impulses and shifts are equal and opposite, and the deformable solver keeps momentum.
TEST(UntanglingLimits, momentum_of_free_bodies_is_kept) {
  Tangle tangle("two-balls", World::deformable, untangling(Detection::dcd));
  tangle.steps_until_clean();
  EXPECT_LT(tangle.drift(), 1e-4);
}

}  // namespace
}  // namespace softcd::test
