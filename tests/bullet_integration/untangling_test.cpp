// Soft bodies that intersect each other, or themselves, with Settings::untangle.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "untangling_support.hpp"

namespace softcd::test {
namespace {

/// Greatest speed of a node, m/s, and kinetic energy, J/kg: one and a half times the measured ones in classic worlds.
/// Springs throw nodes back that the untangling has moved at 1 m/s.
struct Bounds {
  double speed, energy;
};
/// Twice the measured ones in deformable worlds, in which Bullet's random numbers differ from run to run.
struct BoundsOfKind {
  const char* name;
  Bounds classic, deformable;
};
constexpr BoundsOfKind kBounds[] = {
    {"crossed-cloths", {3.6, 0.16}, {7.2, 1.9}},
    {"interlocked-cloths", {4, 0.1}, {8.3, 0.51}},
    {"loop", {5.7, 2.6}, {13.8, 5.9}},
    {"two-balls", {4.8, 0.16}, {4.2, 0.24}},
    {"heap", {6.3, 0.62}, {11.1, 1.7}},
    {"cloth-in-ball", {2, 0.03}, {6.3, 0.08}},
    {"sleeve", {5.4, 1.8}, {4.3, 1.2}},
    {"knot", {3.6, 0.08}, {6.2, 0.72}},
    {"cloth-in-mesh", {2.8, 0.13}, {8.8, 0.47}},
    {"cloth-in-free-mesh", {2.4, 0.13}, {8.5, 0.45}},
    {"cloth-in-slope", {0.55, 0.03}, {2.9, 0.17}},
    {"sleeve-on-mesh", {5.4, 1.8}, {3.9, 1.2}},
};
const Bounds& bounds_of(const char* name, bool is_deformable) {
  const auto* const found = std::find_if(std::begin(kBounds), std::end(kBounds),
                                         [name](const BoundsOfKind& each) { return std::string(name) == each.name; });
  return is_deformable ? found->deformable : found->classic;
}

using Parameters = std::tuple<const char*, World, Detection>;

class Untangling : public testing::TestWithParam<Parameters> {};

TEST_P(Untangling, brings_bodies_apart_gently) {
  const auto [name, world, detection] = GetParam();
  Tangle tangle(name, world, untangling(detection));
  const std::size_t edges = tangle.edges();
  ASSERT_GT(edges, 0U);
  const int steps = tangle.steps_until_clean();
  EXPECT_LT(steps, kMostSteps);
  const Bounds& bounds = bounds_of(name, is_deformable(world));
  EXPECT_LT(tangle.fastest(), bounds.speed);
  EXPECT_LT(tangle.greatest_energy(), tangle.mass() * bounds.energy);
  EXPECT_LT(tangle.drift(), 0.05);
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
                                                          "cloth-in-ball", "sleeve", "knot", "cloth-in-mesh",
                                                          "cloth-in-free-mesh", "cloth-in-slope", "sleeve-on-mesh"),
                                          kLookingWorlds, testing::Values(Detection::dcd, Detection::ccd)),
                         parameter_name);
INSTANTIATE_TEST_SUITE_P(Heap, Untangling,
                         testing::Combine(testing::Values("heap"), testing::Values(World::one_line, World::deformable),
                                          testing::Values(Detection::dcd)),
                         parameter_name);

class UntanglingOff : public testing::TestWithParam<std::tuple<const char*, World, bullet::Untangle>> {};

TEST_P(UntanglingOff, leaves_bodies_that_start_through_each_other) {
  const auto [name, world, untangle] = GetParam();
  Tangle tangle(name, world, untangling(Detection::dcd, untangle));
  for (int i = 0; i < kMostSteps; ++i) tangle.step();
  EXPECT_GT(tangle.edges(), 0U);
  EXPECT_TRUE(tangle.pairs().empty());
}

INSTANTIATE_TEST_SUITE_P(InBothKinds, UntanglingOff,
                         testing::Combine(testing::Values("crossed-cloths", "interlocked-cloths", "two-balls",
                                                          "cloth-in-ball", "sleeve", "cloth-in-mesh",
                                                          "cloth-in-free-mesh", "cloth-in-slope"),
                                          testing::Values(World::one_line, World::deformable),
                                          testing::Values(bullet::Untangle::off, bullet::Untangle::later)));
INSTANTIATE_TEST_SUITE_P(AutomaticallyBetweenSoftBodies, UntanglingOff,
                         testing::Combine(testing::Values("crossed-cloths", "loop", "two-balls", "cloth-in-ball"),
                                          testing::Values(World::deformable),
                                          testing::Values(bullet::Untangle::automatic)));

class UntanglingAutomatic : public testing::TestWithParam<std::tuple<const char*, World>> {};

TEST_P(UntanglingAutomatic, brings_bodies_apart_that_start_through_each_other) {
  const auto [name, world] = GetParam();
  Tangle tangle(name, world, untangling(Detection::dcd, bullet::Untangle::automatic));
  ASSERT_GT(tangle.edges(), 0U);
  EXPECT_LT(tangle.steps_until_clean(), kMostSteps);
}

TEST_P(UntanglingAutomatic, leaves_bodies_with_filters) {
  const auto [name, world] = GetParam();
  Tangle tangle(name, world, untangling(Detection::dcd, bullet::Untangle::automatic));
  btSoftBody& body = *tangle.simulation().bodies()[0];
  bullet::BodyFilters filters;
  filters.nodes.assign(static_cast<std::size_t>(body.m_nodes.size()), {.group = 2, .mask = 2});
  tangle.simulation().detection().set_filters(body, filters);
  for (int i = 0; i < 10; ++i) tangle.step();
  EXPECT_GT(tangle.edges(), 0U);
  EXPECT_TRUE(tangle.pairs().empty());
}

INSTANTIATE_TEST_SUITE_P(InClassicWorlds, UntanglingAutomatic,
                         testing::Combine(testing::Values("crossed-cloths", "two-balls", "cloth-in-ball",
                                                          "cloth-in-mesh"),
                                          testing::Values(World::one_line)));
INSTANTIATE_TEST_SUITE_P(InTheDeformableWorld, UntanglingAutomatic,
                         testing::Combine(testing::Values("cloth-in-mesh", "cloth-in-slope"),
                                          testing::Values(World::deformable)));

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

TEST(UntanglingReport, says_in_the_log_that_a_dispatcher_alone_does_not_untangle) {
  std::string text;
  bullet::Settings settings = untangling(Detection::dcd);
  settings.log = [&](LogLevel, std::string_view message) { text += message; };
  Tangle tangle("two-balls", World::dispatcher, settings);
  for (int i = 0; i < 3; ++i) tangle.step();
  const std::size_t at = text.find("untangling: a softcd::bullet::Dispatcher");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_EQ(text.find("untangling:", at + 1), std::string::npos) << "once";
  EXPECT_TRUE(tangle.pairs().empty());
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

class UntanglingSpeed : public testing::TestWithParam<World> {};

/// The default speed follows the lengths of edges. Bullet's poses of balls in classic worlds depend on the units, and
/// crossed cloths take another time in each run of a deformable world.
TEST_P(UntanglingSpeed, by_default_takes_as_many_steps_in_any_units) {
  bullet::Settings settings = untangling(Detection::dcd);
  settings.untangle_speed = 0;
  const auto steps_in_units = [&, world = GetParam()](btScalar unit) {
    const char* const name = is_deformable(world) ? "two-balls" : "interlocked-cloths";
    Tangle tangle(demo::find_intersecting_bodies(name), world, settings, /*has_meshes=*/false, unit);
    const btVector3 gravity(0, -10 * unit, 0);
    tangle.simulation().set_gravity(gravity);
    tangle.simulation().world().setGravity(gravity);
    return tangle.steps_until_clean();
  };
  const int in_metres = steps_in_units(1);
  EXPECT_LT(in_metres, kMostSteps / 2);
  EXPECT_NEAR(steps_in_units(btScalar(0.01)), in_metres, 3);
  EXPECT_NEAR(steps_in_units(1000), in_metres, 3);
}

INSTANTIATE_TEST_SUITE_P(InBothKinds, UntanglingSpeed, testing::Values(World::one_line, World::deformable), world_name);

TEST(UntanglingLimits, a_speed_out_of_range_is_refused) {
  bullet::Settings settings = untangling(Detection::dcd);
  settings.untangle_speed = -1;
  EXPECT_THROW(AnySimulation(World::one_line, settings), InvalidInput);
}

class UntanglingLater : public testing::TestWithParam<std::tuple<World, Detection>> {
 protected:
  Tangle tangle{"two-balls", std::get<World>(GetParam()),
                untangling(std::get<Detection>(GetParam()), bullet::Untangle::later)};
  btSoftBody& ball = *tangle.simulation().bodies()[1];
};

TEST_P(UntanglingLater, parts_bodies_that_meet_after_the_first_step) {
  shift(ball, btVector3(5, 0, 0));
  tangle.simulation().step_once();
  shift(ball, btVector3(-5, 0, 0));
  ASSERT_GT(tangle.edges(), 0U);
  int steps = 0;
  for (; steps < kMostSteps && tangle.edges() > 0; ++steps) tangle.step();
  EXPECT_LT(steps, kMostSteps);
}

/// Bodies that come apart and meet again are no longer as the app has placed them.
TEST_P(UntanglingLater, parts_bodies_that_meet_again) {
  for (int i = 0; i < 40; ++i) tangle.step();
  ASSERT_GT(tangle.edges(), 0U) << "they stay where the app has placed them";
  shift(ball, btVector3(5, 0, 0));
  for (int i = 0; i < 40; ++i) tangle.step();
  shift(ball, btVector3(-5, 0, 0));
  ASSERT_GT(tangle.edges(), 0U);
  int steps = 0;
  for (; steps < kMostSteps && tangle.edges() > 0; ++steps) tangle.step();
  EXPECT_LT(steps, kMostSteps);
}

TEST_P(UntanglingLater, leaves_a_body_that_is_added_into_another_one) {
  std::unique_ptr<btSoftBody> removed = tangle.simulation().remove(ball);
  for (int i = 0; i < 5; ++i) tangle.step();
  tangle.simulation().add(std::move(removed));
  for (int i = 0; i < 40; ++i) {
    tangle.step();
    EXPECT_TRUE(tangle.pairs().empty()) << "step " << i;
  }
  EXPECT_GT(tangle.edges(), 0U);
}

TEST_P(UntanglingLater, leaves_bodies_that_have_slept) {
  const btAlignedObjectArray<btSoftBody*>& balls = tangle.simulation().bodies();
  for (int i = 0; i < 5; ++i) tangle.step();
  for (int b = 0; b < 2; ++b) balls[b]->forceActivationState(ISLAND_SLEEPING);
  for (int i = 0; i < 5; ++i) tangle.step();
  for (int b = 0; b < 2; ++b) balls[b]->forceActivationState(ACTIVE_TAG);
  for (int i = 0; i < 40; ++i) {
    tangle.step();
    EXPECT_TRUE(tangle.pairs().empty()) << "step " << i;
  }
  EXPECT_GT(tangle.edges(), 0U);
}

TEST_P(UntanglingLater, leaves_bodies_with_filters_to_the_app) {
  shift(ball, btVector3(5, 0, 0));
  tangle.simulation().step_once();
  bullet::BodyFilters filters;
  filters.nodes.assign(static_cast<std::size_t>(ball.m_nodes.size()), {.group = 2, .mask = 2});
  tangle.simulation().detection().set_filters(ball, filters);
  shift(ball, btVector3(-5, 0, 0));
  ASSERT_GT(tangle.edges(), 0U);
  for (int i = 0; i < 40; ++i) {
    tangle.step();
    EXPECT_TRUE(tangle.pairs().empty()) << "step " << i;
  }
  EXPECT_GT(tangle.edges(), 0U);
}

INSTANTIATE_TEST_SUITE_P(InEveryWorld, UntanglingLater,
                         testing::Combine(kLookingWorlds, testing::Values(Detection::dcd, Detection::ccd)),
                         name_of_later);

int count_contacts(Tangle& tangle) {
  const btAlignedObjectArray<btSoftBody*>& bodies = tangle.simulation().bodies();
  return bodies[0]->m_scontacts.size() + bodies[1]->m_scontacts.size();
}

/// Nodes beside the curves carry load. Without contacts they would follow those that have passed through.
TEST(UntanglingLaterContacts, stay_with_the_nodes_on_their_own_side) {
  Tangle from_start("two-balls", World::one_line, untangling(Detection::dcd));
  from_start.simulation().step_once();
  ASSERT_EQ(from_start.pairs().size(), 1U);
  EXPECT_EQ(count_contacts(from_start), 0);

  Tangle later("two-balls", World::one_line, untangling(Detection::dcd, bullet::Untangle::later));
  btSoftBody& ball = *later.simulation().bodies()[1];
  shift(ball, btVector3(5, 0, 0));
  for (int i = 0; i < 32; ++i) later.simulation().step_once();
  shift(ball, btVector3(-5, 0, 0));
  later.simulation().step_once();
  ASSERT_EQ(later.pairs().size(), 1U);
  EXPECT_GT(count_contacts(later), 0);
}

/// In the steps until the next search of all bodies, more would cross.
TEST(UntanglingSearch, begins_in_the_step_after_contacts_are_tangled) {
  bullet::Settings settings = untangling(Detection::dcd, bullet::Untangle::later);
  settings.contacts = bullet::Contacts::automatic;
  Tangle tangle("two-balls", World::one_line, settings);
  btSoftBody& ball = *tangle.simulation().bodies()[1];
  shift(ball, btVector3(5, 0, 0));
  for (int i = 0; i < 5; ++i) tangle.simulation().step_once();
  shift(ball, btVector3(-5, 0, 0));
  tangle.simulation().step_once();
  ASSERT_TRUE(tangle.pairs().empty()) << "not a step in which all bodies are searched";
  ASSERT_GT(tangle.edges(), 0U);
  tangle.simulation().step_once();
  ASSERT_EQ(tangle.pairs().size(), 1U);
  EXPECT_EQ(tangle.pairs()[0].steps, 1U);
}

/// Two crossed cloths of which only one node each can move.
TEST(UntanglingAttempts, become_rare_where_nothing_gives_way) {
  Tangle tangle("crossed-cloths", World::one_line, untangling(Detection::dcd));
  for (int b = 0; b < 2; ++b) {
    btSoftBody& cloth = *tangle.simulation().bodies()[b];
    for (int n = 1; n < cloth.m_nodes.size(); ++n) cloth.setMass(n, 0);
  }
  int steps = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    tangle.step();
    steps += tangle.pairs().empty() ? 0 : 1;
  }
  EXPECT_GT(steps, 20) << "several attempts";
  EXPECT_LT(steps, 40);
}

TEST(UntanglingAttempts, wake_no_body) {
  for (const char* name : {"crossed-cloths", "loop"}) {
    SCOPED_TRACE(name);
    Tangle tangle(name, World::one_line, untangling(Detection::dcd));
    tangle.step();
    ASSERT_EQ(tangle.pairs().size(), 1U);
    const btAlignedObjectArray<btSoftBody*>& all = tangle.simulation().bodies();
    const std::vector<btSoftBody*> bodies(&all[0], &all[0] + all.size());
    for (btSoftBody* body : bodies) {
      for (int n = 1; n < body->m_nodes.size(); ++n) body->setMass(n, 0);
    }
    for (int i = 0; i < 20; ++i) tangle.step();
    ASSERT_TRUE(tangle.pairs().empty());
    for (btSoftBody* body : bodies) body->forceActivationState(ISLAND_SLEEPING);
    SheetOptions far_away;
    far_away.height = 50;
    tangle.simulation().add(make_sheet(tangle.simulation().world_info(), far_away));
    for (int i = 0; i < 100; ++i) {
      tangle.step();
      EXPECT_TRUE(tangle.pairs().empty()) << "step " << i;
    }
    for (const btSoftBody* body : bodies) EXPECT_FALSE(body->isActive());
  }
}

TEST(UntanglingLimits, anchored_nodes_stay) {
  Tangle tangle("two-balls", World::one_line, untangling(Detection::dcd));
  btSoftBody& ball = *tangle.simulation().bodies()[0];
  int inside = 0;
  for (int n = 0; n < ball.m_nodes.size(); ++n) {
    if (ball.m_nodes[n].m_x.x() > ball.m_nodes[inside].m_x.x()) inside = n;
  }
  const btVector3 place = ball.m_nodes[inside].m_x;
  const btVector3 post_place(0, 3, 0);
  btRigidBody& post = tangle.simulation().add_rigid(std::make_unique<btSphereShape>(btScalar(0.01)), post_place);
  ball.appendAnchor(inside, &post);
  tangle.simulation().step_once();
  ASSERT_EQ(tangle.pairs().size(), 1U);
  EXPECT_LT(ball.m_nodes[inside].m_x.distance(place), 1e-4);
}

class UntanglingImpulses : public testing::TestWithParam<World> {};

/// Nothing else acts on the balls.
TEST_P(UntanglingImpulses, are_read_out_as_what_changes_the_momentum) {
  bullet::Settings settings = untangling(Detection::dcd);
  settings.read_out = bullet::ReadOut::impulses;
  Tangle tangle("two-balls", GetParam(), settings);
  const btScalar time = tangle.simulation().step_length();
  const btSoftBody& ball = *tangle.simulation().bodies()[0];
  btScalar greatest = 0;
  for (int step = 0; step < 8; ++step) {
    const btVector3 before = momentum(ball, &btSoftBody::Node::m_v);
    const btVector3 start = momentum(ball, &btSoftBody::Node::m_x);
    tangle.simulation().step(time);
    btVector3 given(0, 0, 0);
    for (const bullet::BodyPairContacts& pair : tangle.simulation().detection().body_contacts()) {
      ASSERT_EQ(pair.a, &ball);
      EXPECT_TRUE(pair.has_impulses);
      given += pair.impulse_a;
    }
    const btVector3 gained = momentum_at_end(GetParam(), ball, start, time) - before;
    EXPECT_NEAR(given.distance(gained), 0, 1e-4) << "kg m/s, of a ball of half a kilogram, in step " << step;
    greatest = btMax(greatest, given.length());
  }
  EXPECT_GT(greatest, 0.01);
}

INSTANTIATE_TEST_SUITE_P(InBothKinds, UntanglingImpulses, testing::Values(World::one_line, World::deformable),
                         world_name);

/// Impulses and shifts are equal and opposite, and the deformable solver keeps momentum.
TEST(UntanglingLimits, momentum_of_free_bodies_is_kept) {
  Tangle tangle("two-balls", World::deformable, untangling(Detection::dcd));
  tangle.steps_until_clean();
  EXPECT_LT(tangle.drift(), 1e-4);
}

}  // namespace
}  // namespace softcd::test
