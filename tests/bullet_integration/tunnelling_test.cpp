// Bodies that are thrown at a cloth must not pass through it, at any speed. Crossings are counted in exact arithmetic.

#include <gtest/gtest.h>

#include <iostream>
#include <tuple>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "deformable_support.hpp"
#include "scenes/penetration.hpp"
#include "scenes/simulation.hpp"
#include "soft_body_steps.hpp"
#include "softcd/bullet/dispatcher.hpp"
#include "softcd/bullet/soft_worlds.hpp"

// Meters per second. In a step the thrown body moves by two of its edges, by nearly the held sheet's side, and far
// beyond all bodies.
#ifndef SOFTCD_SPEEDS
#define SOFTCD_SPEEDS 10, 100, 300
#endif

namespace softcd::test {
namespace {

using demo::DeformableSimulation;
using demo::PlugIn;
using demo::Simulation;

enum class Missile { cloth, ball };

/// Sums over all steps: nodes that meet a face of the other body, and edges in its faces after each step.
struct Passages {
  std::size_t crossings = 0;
  std::size_t edges = 0;
};

/// Throws it, one kilogram, from 0.6 above at a sheet of 20 kilograms that is held along its border.
template <class AnySimulation>
Passages count_passages(AnySimulation& simulation, Missile missile, btScalar speed, btScalar seconds = kStep,
                        int steps = 30, int drift_iterations = 0) {
  SheetOptions options;
  options.side = 2;
  options.nodes_per_side = 17;
  options.margin = btScalar(0.02);
  auto sheet = make_sheet(simulation.world_info(), options);
  sheet->setTotalMass(20);
  for (int n = 0; n < sheet->m_nodes.size(); ++n) {
    const btVector3& x = sheet->m_nodes[n].m_x;
    if (btMax(btFabs(x.x()), btFabs(x.z())) > btScalar(0.99)) sheet->setMass(n, 0);
  }
  btSoftBody& target = simulation.add(std::move(sheet));
  options.side = 1;
  options.nodes_per_side = 12;
  options.height = btScalar(0.6);
  auto body = missile == Missile::ball
                  ? make_soft_ball(simulation.world_info(), btVector3(0, options.height, 0), btScalar(0.3))
                  : make_sheet(simulation.world_info(), options);
  body->getCollisionShape()->setMargin(options.margin);
  btSoftBody& thrown = simulation.add(std::move(body));
  thrown.setVelocity(btVector3(0, -speed, 0));
  for (btSoftBody* each : {&target, &thrown}) each->m_cfg.diterations = drift_iterations;

  CrossingFinder finder({&target, &thrown});
  const auto are_two = [](const btSoftBody& a, const btSoftBody& b) { return &a != &b; };
  Passages passages;
  for (int step = 0; step < steps; ++step) {
    simulation.step(seconds);
    passages.crossings += finder.find().size();
    passages.edges += demo::find_intersections({&target, &thrown}, are_two).edge_count;
  }
  return passages;
}

template <class AnySimulation>
std::size_t count_crossings(AnySimulation& simulation, Missile missile, btScalar speed, btScalar seconds = kStep,
                            int steps = 30, int drift_iterations = 0) {
  return count_passages(simulation, missile, speed, seconds, steps, drift_iterations).crossings;
}

class Tunnelling : public testing::TestWithParam<std::tuple<Missile, int>> {
 protected:
  Missile missile() const { return std::get<0>(GetParam()); }
  btScalar speed() const { return btScalar(std::get<1>(GetParam())); }

  static bullet::Settings settings() {
    bullet::Settings settings = cpu_settings(Detection::ccd);
    settings.log = [](LogLevel level, std::string_view message) {
      if (level == LogLevel::warning) ADD_FAILURE() << message;
    };
    return settings;
  }

  void expect_none_through(const char* world, std::size_t bullets, std::size_t ours) const {
    std::cout << (missile() == Missile::ball ? "ball" : "cloth") << " at " << speed() << " m/s, " << world
              << " world: crossings " << bullets << " with Bullet, " << ours << " with softcd\n";
    EXPECT_EQ(ours, 0U);
    if (speed() > 30) {
      EXPECT_GT(bullets, 50U);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Throws, Tunnelling,
                         testing::Combine(testing::Values(Missile::cloth, Missile::ball),
                                          testing::Values(SOFTCD_SPEEDS)),
                         [](const auto& parameter) {
                           const bool is_ball = std::get<0>(parameter.param) == Missile::ball;
                           return (is_ball ? "ball" : "cloth") + std::to_string(std::get<1>(parameter.param));
                         });

// Springs soft enough for Bullet's explicit integration of nodes of 7 grams.
const demo::DeformableMaterial kSoft = {1, btScalar(0.01), btScalar(0.1)};

TEST_P(Tunnelling, none_in_the_deformable_world) {
  DeformableSimulation ours(settings(), kSoft);
  DeformableSimulation bullets(std::nullopt, kSoft);
  expect_none_through("deformable", count_crossings(bullets, missile(), speed()),
                      count_crossings(ours, missile(), speed()));
}

TEST_P(Tunnelling, none_in_the_classic_world) {
  Simulation ours(PlugIn::one_line_world, settings());
  Simulation bullets(PlugIn::none);
  expect_none_through("classic", count_crossings(bullets, missile(), speed()),
                      count_crossings(ours, missile(), speed()));
}

// With responses to edges, tangled features are released. So none may become tangled.
TEST_P(Tunnelling, none_where_edges_are_answered) {
  bullet::Settings answered = settings();
  answered.edge_contacts = bullet::EdgeContacts::respond;
  Simulation classic(PlugIn::one_line_world, answered);
  DeformableSimulation deformable(answered, kSoft);
  for (const Passages& passages :
       {count_passages(classic, missile(), speed()), count_passages(deformable, missile(), speed())}) {
    EXPECT_EQ(passages.crossings, 0U);
    EXPECT_EQ(passages.edges, 0U);
  }
}

/// softcd's world, which leaves contacts to softcd's dispatcher.
class WorldOnDispatcher {
 public:
  WorldOnDispatcher() {
    world_.setGravity(btVector3(0, -10, 0));
    world_info().m_gravity = btVector3(0, -10, 0);
  }
  ~WorldOnDispatcher() {
    for (const auto& body : bodies_) world_.removeSoftBody(body.get());
  }
  WorldOnDispatcher(const WorldOnDispatcher&) = delete;
  WorldOnDispatcher& operator=(const WorldOnDispatcher&) = delete;

  btSoftBodyWorldInfo& world_info() { return world_.getWorldInfo(); }
  btSoftBody& add(std::unique_ptr<btSoftBody> body) {
    world_.addSoftBody(body.get());
    bodies_.push_back(std::move(body));
    return *bodies_.back();
  }
  void step(btScalar seconds) { world_.stepSimulation(seconds, /*maxSubSteps=*/0); }

 private:
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  bullet::Broadphase broadphase_{std::make_unique<btDbvtBroadphase>()};
  bullet::Dispatcher dispatcher_{&configuration_, broadphase_, cpu_settings(Detection::ccd)};
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btSoftBody>> bodies_;
  bullet::SoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

template <class AnySimulation>
std::size_t count_crossings_with_drift(AnySimulation& simulation) {
  return count_crossings(simulation, Missile::ball, 100, kStep, 10, /*drift_iterations=*/2);
}

// Bullet's solver then puts its own result in place of where the step began.
TEST(Drift, lets_nothing_through) {
  for (const PlugIn plug_in : {PlugIn::one_line_world, PlugIn::multi_body_world, PlugIn::attached}) {
    Simulation simulation(plug_in, cpu_settings(Detection::ccd));
    EXPECT_EQ(count_crossings_with_drift(simulation), 0U);
  }
  WorldOnDispatcher simulation;
  EXPECT_EQ(count_crossings_with_drift(simulation), 0U);
}

/// Five free sheets lie 10 cm above each other; the uppermost and heaviest is thrown at the others, 19 cm in a step.
template <class AnySimulation>
std::size_t count_crossings_in_a_pile(AnySimulation& simulation) {
  SheetOptions options;
  options.nodes_per_side = 8;
  options.margin = btScalar(0.01);
  std::vector<btSoftBody*> sheets;
  for (int i = 0; i < 5; ++i) {
    options.height = btScalar(0.1) * btScalar(i);
    sheets.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
  }
  sheets.back()->setTotalMass(10);
  sheets.back()->setVelocity(btVector3(0, btScalar(-0.19) / kStep, 0));
  CrossingFinder finder(sheets);
  std::size_t crossings = 0;
  for (int step = 0; step < 10; ++step) {
    simulation.step(kStep);
    crossings += finder.find().size();
  }
  return crossings;
}

// The response moves the sheet that was hit into the next one, and so on.
TEST(Piles, what_is_pushed_does_not_pass_through_the_next) {
  Simulation classic(PlugIn::one_line_world, cpu_settings(Detection::ccd));
  EXPECT_EQ(count_crossings_in_a_pile(classic), 0U);
  DeformableSimulation deformable(cpu_settings(Detection::ccd), kSoft);
  EXPECT_EQ(count_crossings_in_a_pile(deformable), 0U);
}

// From steps in which nothing seems to move to steps in which gravity alone moves a kilometre.
class TimeSteps : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Seconds, TimeSteps, testing::Values(1e-9, 10.0));

TEST_P(TimeSteps, let_nothing_through) {
  const btScalar seconds = btScalar(GetParam());
  constexpr int kSteps = 5;
  for (const Missile missile : {Missile::cloth, Missile::ball}) {
    Simulation classic(PlugIn::one_line_world, cpu_settings(Detection::ccd));
    EXPECT_EQ(count_crossings(classic, missile, 20, seconds, kSteps), 0U);
    DeformableSimulation deformable(cpu_settings(Detection::ccd), kSoft);
    EXPECT_EQ(count_crossings(deformable, missile, 20, seconds, kSteps), 0U);
  }
}

}  // namespace
}  // namespace softcd::test
