// Nodes that the app moves: softcd gives way where it can, and reports crossings that it cannot prevent.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <regex>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "scenes/penetration.hpp"
#include "soft_body_steps.hpp"
#include "warned_simulation.hpp"

namespace softcd::test {
namespace {

class MovedByOthers : public WarnedSimulation {
 protected:
  btSoftBody& add_sheet(btScalar height, bool fixed, int nodes_per_side = 7) {
    SheetOptions options;
    options.nodes_per_side = nodes_per_side;
    options.height = height;
    options.margin = btScalar(0.01);
    options.fixed = fixed;
    bodies.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
    return *bodies.back();
  }

  /// Without mass.
  void add_ball(btScalar height) {
    auto ball = demo::make_ball(simulation.world_info(), btVector3(btScalar(0.03), height, 0), btScalar(0.2), 2);
    for (int n = 0; n < ball->m_nodes.size(); ++n) ball->setMass(n, 0);
    ball->getCollisionShape()->setMargin(btScalar(0.01));
    bodies.push_back(&simulation.add(std::move(ball)));
  }

  static void send(btSoftBody& body, const btVector3& velocity) {
    for (int n = 0; n < body.m_nodes.size(); ++n) body.m_nodes[n].m_v = velocity;
  }
  std::size_t count_intersections() const { return count_edges({bodies.begin(), bodies.end()}); }

  std::vector<btSoftBody*> bodies;
};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedByOthers, kLookingWorlds, world_name);

class MovedByAnchors : public MovedByOthers {};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedByAnchors, testing::Values(World::deformable, World::attached_deformable),
                         world_name);

// Bullet puts nodes on anchors to their anchors, whatever their velocity.
TEST_P(MovedByAnchors, through_something_are_counted_and_named) {
  add_sheet(0, /*fixed=*/true);
  btSoftBody& pulled = add_sheet(btScalar(0.05), /*fixed=*/false, 4);
  const btVector3 place = pulled.m_nodes[5].m_x;
  btRigidBody& hand = simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.01)), place);
  hand.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  hand.setActivationState(DISABLE_DEACTIVATION);
  pulled.appendDeformableAnchor(5, &hand);
  std::uint64_t unavoidable = 0;
  for (int step = 0; step < 3; ++step) {
    simulation.step([&](btScalar) {
      hand.getWorldTransform().getOrigin() -= btVector3(0, btScalar(0.02), 0);
      unavoidable += simulation.detection().crossing_answers().unavoidable;
    });
  }
  EXPECT_LT(pulled.m_nodes[5].m_x.y(), 0) << "the hand went there";
  EXPECT_GT(count_intersections(), 0U);
  EXPECT_GT(unavoidable, 0U);
  ASSERT_EQ(warnings.size(), 1U) << "of twelve steps";
  EXPECT_NE(warnings[0].find("anchors"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("soft bodies 0 and 1 "), std::string::npos) << warnings[0];
}

TEST_P(MovedByAnchors, push_what_is_free_out_of_their_way) {
  btSoftBody& free_one = add_sheet(0, /*fixed=*/false);
  btSoftBody& pulled = add_sheet(btScalar(0.05), /*fixed=*/false, 4);
  const btVector3 place = pulled.m_nodes[5].m_x;
  btRigidBody& hand = simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.001)), place);
  hand.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  hand.setActivationState(DISABLE_DEACTIVATION);
  hand.setIgnoreCollisionCheck(&free_one, true);
  pulled.appendDeformableAnchor(5, &hand);
  for (int step = 0; step < 8; ++step) {
    simulation.step([&](btScalar) { hand.getWorldTransform().getOrigin() -= btVector3(0, btScalar(0.005), 0); });
    EXPECT_EQ(count_intersections(), 0U);
  }
  EXPECT_LT(pulled.m_nodes[5].m_x.y(), btScalar(-0.05));
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

// A ball moves with five metres a second through five free cloths.
TEST_P(MovedByOthers, a_ball_takes_a_pile_of_cloths_along) {
  for (int i = 0; i < 5; ++i) add_sheet(btScalar(0.05) * btScalar(i), /*fixed=*/false);
  add_ball(btScalar(-0.3));
  for (int step = 0; step < 20; ++step) {
    simulation.step([&](btScalar) { send(*bodies.back(), btVector3(0, 5, 0)); });
    EXPECT_EQ(count_intersections(), 0U) << "step " << step;
  }
  EXPECT_GT(mean_height(*bodies.back()), 1);
  EXPECT_GT(mean_height(*bodies[4]), mean_height(*bodies.back()) - btScalar(0.5));
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

class ThroughPiles : public MovedByOthers {
 protected:
  /// Throws a ball at five cloths, half of whose nodes may be held: 0.5 m a step and more.
  void throw_ball(btScalar speed, bool holds_cloths) {
    for (int i = 0; i < 5; ++i) {
      btSoftBody& cloth = add_sheet(btScalar(0.05) * btScalar(i), /*fixed=*/false, 7 - i % 2);
      for (int n = 0; holds_cloths && n < cloth.m_nodes.size(); n += 2) cloth.setMass(n, 0);
    }
    add_ball(-1);
    for (int step = 0; step < 10; ++step) {
      simulation.step([&](btScalar) {
        see_step();
        send(*bodies.back(), btVector3(0, speed, 0));
      });
      see_step();
    }
    EXPECT_GT(mean_height(*bodies.back()), 1) << "above the pile";
  }
  void see_step() {
    unavoidable += simulation.detection().crossing_answers().unavoidable;
    const std::size_t edges = count_intersections();
    most_edges = std::max(most_edges, edges);
    if (edges > 0) {
      EXPECT_GT(unavoidable, 0U) << edges << " edges are in faces and nothing was said";
    }
  }

  std::uint64_t unavoidable = 0;
  std::size_t most_edges = 0;
};
INSTANTIATE_TEST_SUITE_P(Worlds, ThroughPiles, kLookingWorlds, world_name);

TEST_P(ThroughPiles, a_ball_at_30_metres_a_second_takes_free_cloths_along) {
  throw_ball(30, /*holds_cloths=*/false);
  EXPECT_EQ(most_edges, 0U);
  EXPECT_EQ(unavoidable, 0U);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(ThroughPiles, a_ball_at_100_metres_a_second_takes_free_cloths_along) {
  throw_ball(100, /*holds_cloths=*/false);
  EXPECT_EQ(most_edges, 0U);
  EXPECT_EQ(unavoidable, 0U);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(ThroughPiles, a_ball_through_held_cloths_is_counted_and_named) {
  throw_ball(30, /*holds_cloths=*/true);
  EXPECT_GT(most_edges, 0U);
  EXPECT_GT(unavoidable, 0U);
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("nodes without mass"), std::string::npos) << warnings[0];
  std::set<std::string> pairs;
  for (const std::string& warning : warnings) {
    const std::regex pair("[0-9]+ and [0-9]+");
    for (std::sregex_iterator found(warning.begin(), warning.end(), pair), end; found != end; ++found) {
      EXPECT_TRUE(pairs.insert(found->str()).second) << "named twice: " << found->str();
    }
  }
  EXPECT_GE(pairs.size(), 5U) << "the ball and each cloth";
}

// A body that the app puts through another is released from that one only.
TEST_P(MovedByOthers, a_sheet_put_through_another_is_excepted_alone) {
  btSoftBody& first = add_sheet(0, /*fixed=*/true);
  btSoftBody& second = add_sheet(btScalar(0.04), /*fixed=*/false, 6);
  btSoftBody& third = add_sheet(btScalar(0.5), /*fixed=*/false, 5);
  simulation.step();
  EXPECT_EQ(count_intersections(), 0U);
  second.rotate(btQuaternion(btVector3(0, 0, 1), btScalar(0.5)));
  std::uint64_t excepted = 0;
  CrossingFinder finder({&first, &third});
  const auto see_step = [&] { EXPECT_TRUE(finder.find().empty()) << "nothing excepts the third"; };
  for (int step = 0; step < 20; ++step) {
    send(second, btVector3(0, 1, 0));
    simulation.step([&](btScalar) {
      see_step();
      send(third, btVector3(0, -3, 0));
      excepted += simulation.detection().crossing_answers().excepted;
    });
    see_step();
    EXPECT_EQ(demo::find_intersections({&first, &third}).edge_count, 0U);
    EXPECT_EQ(demo::find_intersections({&second, &third}).edge_count, 0U);
  }
  EXPECT_GT(excepted, 0U);
  ASSERT_EQ(warnings.size(), 1U) << "of 20 steps";
  EXPECT_NE(warnings[0].find("soft bodies 0 and 1 "), std::string::npos) << warnings[0];
}

// A piston that comes down to a third of their gap, stays, and goes.
TEST_P(MovedByOthers, sheets_under_a_piston_get_no_energy_and_come_apart) {
  add_sheet(0, /*fixed=*/true);
  for (int i = 1; i < 4; ++i) add_sheet(btScalar(0.03) * btScalar(i), /*fixed=*/false, 5 + i);
  btSoftBody& piston = add_sheet(btScalar(0.12), /*fixed=*/true, 6);
  btScalar fastest = 0;
  double most_given = 0;  // by the responses of one step, after it has come down
  for (int step = 0; step < 60; ++step) {
    simulation.step([&](btScalar) {
      if (step > 10) most_given = std::max(most_given, simulation.detection().crossing_answers().energy);
      const btScalar speed = step < 10 ? btScalar(-0.36) : (step < 40 ? btScalar(0) : btScalar(1));
      send(piston, btVector3(0, speed, 0));
    });
    EXPECT_EQ(count_intersections(), 0U) << "step " << step;
    double energy = 0;
    for (std::size_t b = 1; b < 4; ++b) {
      energy += kinetic_energy(*bodies[b]);
      for (int n = 0; n < bodies[b]->m_nodes.size(); ++n) {
        fastest = btMax(fastest, bodies[b]->m_nodes[n].m_v.length());
      }
    }
    EXPECT_LT(energy, 0.5) << "a third of that of the sheets at the piston's speed";
  }
  EXPECT_LT(fastest, 2) << "the piston's own speed is 1";
  EXPECT_LT(most_given, 1e-6);
  for (std::size_t b = 1; b < 4; ++b) {
    const btScalar gap = mean_height(*bodies[b]) - mean_height(*bodies[b - 1]);
    // The deformable world's gravity, which is not the bodies', presses them onto the lowest.
    EXPECT_GT(gap, is_deformable(GetParam()) ? btScalar(0) : btScalar(0.03)) << "of 0.01 when it was down";
  }
}

/// Two cloths on the ground that the app puts to sleep.
class MovedAsleep : public MovedByOthers {
 protected:
  void lay_cloths() {
    simulation.set_gravity(btVector3(0, -10, 0));
    simulation.add_rigid(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0), btVector3(0, 0, 0));
    SheetOptions options;
    options.margin = btScalar(0.02);
    for (const auto& [nodes_per_side, side, height] :
         {std::tuple(10, btScalar(1), btScalar(0.05)), std::tuple(9, btScalar(0.8), btScalar(0.15))}) {
      options.nodes_per_side = nodes_per_side;
      options.side = side;
      options.height = height;
      bodies.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
    }
    bodies[1]->translate(btVector3(btScalar(0.05), 0, btScalar(0.03)));
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedAsleep, kLookingWorlds, world_name);

// Bullet's deformable world goes on to move sleeping bodies out of the contacts of their last step.
TEST_P(MovedAsleep, do_not_get_through_each_other) {
  lay_cloths();
  std::size_t intersections = 0;
  for (int i = 0; i < 90; ++i) {
    simulation.step();
    intersections += count_intersections();
    if (i < 29) continue;
    for (btSoftBody* body : bodies) body->forceActivationState(i % 30 < 15 ? ACTIVE_TAG : ISLAND_SLEEPING);
  }
  EXPECT_EQ(intersections, 0U);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

// Bullet's classic solver moves the nodes of bodies without simulation in the contacts of active ones.
TEST_P(MovedAsleep, by_what_lies_on_them_do_not_get_through_the_next) {
  lay_cloths();
  btSoftBody& top = add_sheet(btScalar(0.25), /*fixed=*/false, 8);
  top.getCollisionShape()->setMargin(btScalar(0.02));
  std::size_t intersections = 0;
  for (int i = 0; i < 90; ++i) {
    if (i == 30) bodies[1]->forceActivationState(DISABLE_SIMULATION);
    simulation.step();
    intersections += count_intersections();
  }
  EXPECT_EQ(intersections, 0U);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

std::vector<btVector3> values_of(const btSoftBody& body, btVector3 btSoftBody::Node::*member) {
  std::vector<btVector3> values;
  for (int n = 0; n < body.m_nodes.size(); ++n) values.push_back(body.m_nodes[n].*member);
  return values;
}

class DisabledBodies : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, DisabledBodies, kWorlds, world_name);

// Contacts alone would move them in each step, and no spring would move them back.
TEST_P(DisabledBodies, stay_under_bodies_that_fall_on_them) {
  for (const bullet::Settings& settings : {cpu_settings(), careful_settings(), bullet::Settings::safe()}) {
    AnySimulation simulation(GetParam(), settings);
    simulation.set_gravity(btVector3(0, -10, 0));
    SheetOptions options;
    options.margin = btScalar(0.02);
    btSoftBody& disabled = simulation.add(make_sheet(simulation.world_info(), options));
    options.height = btScalar(0.1);
    options.side = btScalar(0.8);
    const btSoftBody& falling = simulation.add(make_sheet(simulation.world_info(), options));
    disabled.forceActivationState(DISABLE_SIMULATION);
    const std::vector<btVector3> places = values_of(disabled, &btSoftBody::Node::m_x);
    for (int step = 0; step < 30; ++step) simulation.step();
    EXPECT_EQ(values_of(disabled, &btSoftBody::Node::m_x), places);
    EXPECT_EQ(momentum(disabled, &btSoftBody::Node::m_v), btVector3(0, 0, 0));
    EXPECT_GT(lowest_height(falling), 0);
    EXPECT_LT(mean_height(falling), 0.06) << "it lies there";

    simulation.set_gravity(btVector3(0, 0, 0));
    disabled.forceActivationState(ACTIVE_TAG);
    for (int step = 0; step < 5; ++step) simulation.step();
    EXPECT_LT(momentum(disabled, &btSoftBody::Node::m_v).length(), 0.1) << "of one kilogram";
  }
}

class MovedWithoutSimulation : public MovedByOthers {};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedWithoutSimulation, kLookingWorlds, world_name);

// A body that the app stops in flight keeps its velocity, but does not move by it.
TEST_P(MovedWithoutSimulation, do_not_throw_bodies_by_velocities_that_they_keep) {
  btSoftBody& stopped = add_sheet(0, /*fixed=*/false);
  btSoftBody& thrown = add_sheet(btScalar(0.05), /*fixed=*/false, 6);
  const btVector3 velocity(0, 20, 0);
  send(stopped, velocity);
  stopped.forceActivationState(DISABLE_SIMULATION);
  send(thrown, -velocity);
  const double energy = kinetic_energy(thrown);
  simulation.step_once();
  EXPECT_EQ(count_intersections(), 0U);
  EXPECT_EQ(mean_height(stopped), 0);
  EXPECT_EQ(stopped.m_nodes[0].m_v, velocity);
  EXPECT_LT(kinetic_energy(thrown), energy / 2);
}

TEST_P(MovedWithoutSimulation, do_not_push_bodies_within_their_margins_by_these_velocities) {
  btSoftBody& stopped = add_sheet(0, /*fixed=*/false);
  const btSoftBody& resting = add_sheet(btScalar(0.015), /*fixed=*/false, 6);
  send(stopped, btVector3(0, 20, 0));
  stopped.forceActivationState(DISABLE_SIMULATION);
  simulation.step_once();
  EXPECT_EQ(mean_height(stopped), 0);
  EXPECT_LT(momentum(resting, &btSoftBody::Node::m_v).length(), 1) << "of one kilogram";
}

TEST_P(MovedWithoutSimulation, make_way_only_if_others_have_no_place_to_go) {
  btSoftBody& free_one = add_sheet(0, /*fixed=*/false);
  btSoftBody& disabled = add_sheet(btScalar(0.05), /*fixed=*/false, 6);
  disabled.forceActivationState(DISABLE_SIMULATION);
  add_ball(btScalar(-0.3));
  for (int step = 0; step < 20; ++step) {
    simulation.step([&](btScalar) { send(*bodies.back(), btVector3(0, 5, 0)); });
    EXPECT_EQ(count_intersections(), 0U) << "step " << step;
  }
  EXPECT_GT(mean_height(*bodies.back()), 1);
  EXPECT_GT(mean_height(free_one), 0);
  EXPECT_GT(mean_height(disabled), btScalar(0.05));
  EXPECT_EQ(kinetic_energy(disabled), 0) << "for the time when it is simulated again";
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

}  // namespace
}  // namespace softcd::test
