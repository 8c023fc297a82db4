// Massless nodes that the app moves by m_x push what is in their way, as if their velocity moved them.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "attached_worlds.hpp"
#include "bodies/massless_node_paths.hpp"
#include "failing_allocations.hpp"
#include "interruption.hpp"
#include "scenes/soft_ball.hpp"
#include "warned_simulation.hpp"

namespace softcd::test {
namespace {

using Node = btSoftBody::Node;

constexpr int kNodesPerSide = 9;
constexpr btScalar kMargin = btScalar(0.02);

/// Which of a cloth's nodes have no mass.
enum class Massless { none, every_second, all };

class MovedMassless : public WarnedSimulation {
 protected:
  explicit MovedMassless(const bullet::Settings& settings = bullet::Settings::safe())
      : WarnedSimulation(on_cpu(settings)) {}
  static bullet::Settings on_cpu(bullet::Settings settings) {
    settings.backend = Backend::cpu;
    return settings;
  }

  btSoftBody& add_cloth(btScalar height, Massless which) {
    SheetOptions options;
    options.nodes_per_side = kNodesPerSide;
    options.height = height;
    options.margin = kMargin;
    btSoftBody& cloth = simulation.add(make_sheet(simulation.world_info(), options));
    const int stride = which == Massless::every_second ? 2 : 1;
    for (int n = 0; which != Massless::none && n < cloth.m_nodes.size(); n += stride) cloth.setMass(n, 0);
    cloth.setActivationState(DISABLE_DEACTIVATION);
    return cloth;
  }
  /// On a box.
  void lay_ball() {
    simulation.set_gravity(btVector3(0, -10, 0));
    simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(4, btScalar(0.5), 4)), btVector3(0, btScalar(-0.5), 0));
    demo::SoftBallShape shape;
    shape.center = {btScalar(0.02), btScalar(0.28), btScalar(0.01)};
    shape.radius = btScalar(0.25);
    shape.subdivisions = 2;
    shape.mass = 1;
    shape.margin = kMargin;
    ball = &simulation.add(demo::make_soft_ball(simulation.world_info(), kind(), shape));
    ball->setActivationState(DISABLE_DEACTIVATION);
  }
  static demo::World kind() { return is_deformable(GetParam()) ? demo::World::deformable : demo::World::classic; }

  static btTriangleMesh triangle(const btVector3& center) {
    btTriangleMesh mesh;
    mesh.addTriangle(center + btVector3(btScalar(-0.1), 0, btScalar(-0.1)), center + btVector3(0, 0, btScalar(0.2)),
                     center + btVector3(btScalar(0.1), 0, btScalar(-0.1)));
    return mesh;
  }

  static std::vector<Node*> massless_nodes(btSoftBody& body) {
    std::vector<Node*> nodes;
    for (int n = 0; n < body.m_nodes.size(); ++n) {
      if (!(body.m_nodes[n].m_im > 0)) nodes.push_back(&body.m_nodes[n]);
    }
    return nodes;
  }
  static void move_massless(btSoftBody& body, const btVector3& by) {
    for (Node* node : massless_nodes(body)) node->m_x += by;
  }
  static void expect_at_rest(btSoftBody& body, const std::vector<btVector3>& places) {
    const std::vector<Node*> nodes = massless_nodes(body);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      EXPECT_EQ(nodes[i]->m_x, places[i]);
      EXPECT_EQ(nodes[i]->m_v, btVector3(0, 0, 0));
    }
  }
  /// In the deformable world the rounding of its springs' lengths moves a body at rest.
  static void expect_unmoved(const btSoftBody& body, const std::vector<btVector3>& places) {
    if (!is_deformable(GetParam())) {
      EXPECT_EQ(bullet::values_of(body, &Node::m_x), places);
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_LT(body.m_nodes[int(i)].m_x.distance(places[i]), btScalar(1e-6));
    }
  }
  static std::vector<btVector3> places_of(btSoftBody& body) {
    std::vector<btVector3> places;
    for (const Node* node : massless_nodes(body)) places.push_back(node->m_x);
    return places;
  }

  /// Moves the cloth's massless nodes down through the other body's place, at `speed` metres a second.
  void push_down(btSoftBody& cloth, const btSoftBody& other, btScalar speed, btScalar lowest, int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      const bool moves = massless_nodes(cloth)[0]->m_x.y() > lowest;
      if (moves) move_massless(cloth, btVector3(0, -speed * kStep, 0));
      const std::vector<btVector3> places = places_of(cloth);
      simulation.step();
      expect_at_rest(cloth, places);
      ASSERT_EQ(count_edges({&cloth, &other}), 0U) << "frame " << frame;
    }
    EXPECT_TRUE(warnings.empty()) << warnings[0];
  }

  btSoftBody* ball = nullptr;
};
/// Bullet makes each kind of step in its own order.
const auto kWorldsWithPaths =
    testing::Values(World::one_line, World::multi_body, World::attached, World::deformable, World::attached_deformable);
INSTANTIATE_TEST_SUITE_P(Worlds, MovedMassless, kWorldsWithPaths, world_name);

TEST_P(MovedMassless, nodes_bring_a_cloth_down_on_a_ball) {
  lay_ball();
  push_down(add_cloth(1, Massless::every_second), *ball, /*speed=*/2, /*lowest=*/btScalar(0.4), 180);
}

TEST_P(MovedMassless, cloth_comes_down_on_a_ball) {
  lay_ball();
  push_down(add_cloth(1, Massless::all), *ball, /*speed=*/1, /*lowest=*/btScalar(0.4), 180);
}

TEST_P(MovedMassless, cloth_comes_down_slowly_on_a_ball) {
  lay_ball();
  push_down(add_cloth(btScalar(0.7), Massless::all), *ball, btScalar(0.4), /*lowest=*/btScalar(0.4), 60);
}

TEST_P(MovedMassless, cloth_comes_down_fast_on_a_ball) {
  lay_ball();
  push_down(add_cloth(btScalar(0.7), Massless::all), *ball, /*speed=*/2, /*lowest=*/btScalar(0.4), 60);
}

// Bullet's classic solver overwrites the starts of such a body's paths.
TEST_P(MovedMassless, cloth_with_drift_iterations_comes_down_on_a_ball) {
  lay_ball();
  btSoftBody& cloth = add_cloth(1, Massless::every_second);
  cloth.m_cfg.diterations = 1;
  push_down(cloth, *ball, /*speed=*/2, /*lowest=*/btScalar(0.4), 120);
}

// In positions near 0 sums of starts and velocities round differently from the places that the app gives.
TEST_P(MovedMassless, cloth_that_takes_a_free_one_along_ends_near_the_origin) {
  const btSoftBody& free_one = add_cloth(btScalar(-0.1), Massless::none);
  btSoftBody& cloth = add_cloth(0, Massless::all);
  simulation.step();
  for (int frame = 0; frame < 40; ++frame) {
    for (Node* node : massless_nodes(cloth)) {
      node->m_x += btVector3(btScalar(0.013), btScalar(frame % 2 == 0 ? -0.37 : 0.3699), 0);
    }
    const std::vector<btVector3> places = places_of(cloth);
    simulation.step();
    expect_at_rest(cloth, places);
    ASSERT_EQ(count_edges({&cloth, &free_one}), 0U) << "frame " << frame;
  }
  EXPECT_LT(mean_height(free_one), btScalar(-0.3));
}

// The mesh is out of reach of both ends of the nodes' paths.
TEST_P(MovedMassless, nodes_that_pass_through_a_mesh_are_named) {
  btTriangleMesh mesh = triangle(btVector3(0, btScalar(-0.2), 0));
  simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&mesh, /*quantised=*/true), btVector3(0, 0, 0));
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  simulation.step();
  EXPECT_TRUE(warnings.empty());
  move_massless(cloth, btVector3(0, btScalar(-0.4), 0));
  const std::vector<btVector3> places = places_of(cloth);
  simulation.step();
  expect_at_rest(cloth, places);
  EXPECT_FALSE(warnings.empty());
}

TEST_P(MovedMassless, cloth_takes_a_free_one_along) {
  const btSoftBody& free_one = add_cloth(btScalar(-0.1), Massless::none);
  push_down(add_cloth(0, Massless::all), free_one, /*speed=*/2, /*lowest=*/-2, 60);
  EXPECT_LT(mean_height(free_one), btScalar(-1.5));
}

TEST_P(MovedMassless, nodes_keep_velocities_of_their_own) {
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  simulation.step();
  btVector3 velocity(0, 0, 3);
  for (Node* node : massless_nodes(cloth)) node->m_v = velocity;
  for (int frame = 0; frame < 3; ++frame) {
    const btVector3 place = massless_nodes(cloth)[0]->m_x;
    move_massless(cloth, btVector3(0, btScalar(-0.02), 0));
    simulation.step();
    const btVector3 expected = place + btVector3(0, btScalar(-0.02), 0) + velocity * kStep;
    EXPECT_LT(massless_nodes(cloth)[0]->m_x.distance(expected), btScalar(1e-5));
    if (!is_deformable(GetParam())) velocity *= 1 - cloth.m_cfg.kDP;
    for (const Node* node : massless_nodes(cloth)) EXPECT_LT(node->m_v.distance(velocity), btScalar(1e-5));
  }
}

TEST_P(MovedMassless, nodes_strike_nothing_where_their_body_is_placed_anew) {
  const std::vector<std::function<void(btSoftBody&)>> placements = {
      [](btSoftBody& body) { body.translate(btVector3(0, btScalar(-0.6), 0)); },
      [](btSoftBody& body) {  // as an app does that restores a state
        for (Node* node : massless_nodes(body)) node->m_q = node->m_x -= btVector3(0, btScalar(0.6), 0);
      },
      // By more than its size.
      [](btSoftBody& body) { move_massless(body, btVector3(0, -2, 0)); },
  };
  for (const auto& place : placements) {
    btSoftBody& placed = add_cloth(btScalar(0.3), Massless::all);
    btSoftBody& between = add_cloth(0, Massless::none);
    for (int frame = 0; frame < 2; ++frame) simulation.step();
    const std::vector<btVector3> places = bullet::values_of(between, &Node::m_x);
    place(placed);
    for (int frame = 0; frame < 2; ++frame) simulation.step();
    expect_unmoved(between, places);
    EXPECT_LT(mean_height(placed), btScalar(-0.2));
    simulation.remove(placed);
    simulation.remove(between);
  }
}

TEST_P(MovedMassless, nodes_end_where_the_app_puts_them_beyond_bullets_greatest_displacement) {
  simulation.world_info().m_maxDisplacement = btScalar(0.01);
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  simulation.step();
  move_massless(cloth, btVector3(0, btScalar(-0.05), 0));
  const std::vector<btVector3> places = places_of(cloth);
  simulation.step();
  expect_at_rest(cloth, places);
}

TEST_P(MovedMassless, nodes_of_a_new_body_at_the_same_place_have_no_path) {
  btSoftBody& between = add_cloth(0, Massless::none);
  btSoftBody* moved = &add_cloth(btScalar(0.3), Massless::all);
  for (int frame = 0; frame < 2; ++frame) simulation.step();
  const std::vector<btVector3> places = bullet::values_of(between, &Node::m_x);
  std::unique_ptr<btSoftBody> removed = simulation.remove(*moved);
  removed->translate(btVector3(0, btScalar(-0.6), 0));
  moved = &simulation.add(std::move(removed));
  for (int frame = 0; frame < 2; ++frame) simulation.step();
  expect_unmoved(between, places);
}

TEST_P(MovedMassless, nodes_have_their_own_velocities_after_a_step_that_throws) {
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  simulation.step();
  move_massless(cloth, btVector3(0, btScalar(-0.02), 0));
  {
    const Interruption interruption(simulation.world(), When::in_action, [] { throw std::runtime_error("the app's"); });
    EXPECT_THROW(simulation.step(), std::runtime_error);
  }
  const std::vector<btVector3> places = places_of(cloth);
  simulation.step();
  expect_at_rest(cloth, places);
}

class MovedMasslessImpulses : public MovedMassless {
 protected:
  MovedMasslessImpulses() : MovedMassless(read_out()) {}
  static bullet::Settings read_out() {
    bullet::Settings settings = cpu_settings();
    settings.read_out = bullet::ReadOut::impulses;
    return settings;
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedMasslessImpulses, kWorldsWithPaths, world_name);

TEST_P(MovedMasslessImpulses, are_those_of_the_velocity_of_their_path) {
  btSoftBody& free_one = add_cloth(btScalar(-0.035), Massless::none);
  btSoftBody& cloth = add_cloth(0, Massless::all);
  simulation.step();
  move_massless(cloth, btVector3(0, btScalar(-0.03), 0));
  const btVector3 before = momentum(free_one, &Node::m_v);
  const btVector3 start = momentum(free_one, &Node::m_x);
  simulation.step_once();
  const std::vector<bullet::BodyPairContacts>& pairs = simulation.detection().body_contacts();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_TRUE(pairs[0].has_impulses);
  const btVector3 given = pairs[0].a == &free_one ? pairs[0].impulse_a : pairs[0].impulse_b;
  EXPECT_LT(given.y(), btScalar(-0.1));
  EXPECT_LT(given.distance(momentum_at_end(GetParam(), free_one, start, simulation.step_length()) - before),
            btScalar(1e-4));
}

class MovedMasslessDeformable : public MovedMassless {};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedMasslessDeformable,
                         testing::Values(World::deformable, World::attached_deformable), world_name);

// Bullet's rule for contacts uses the normals of faces.
TEST_P(MovedMasslessDeformable, contacts_have_the_normals_of_the_start_of_the_path) {
  const btSoftBody& free_one = add_cloth(btScalar(-0.03), Massless::none);
  btSoftBody& cloth = add_cloth(0, Massless::all);
  simulation.step_once();
  for (Node* node : massless_nodes(cloth)) node->m_x += btVector3(0, node->m_x.z() - btScalar(0.5), 0);
  simulation.step_once();
  int count = 0;
  for (const btSoftBody* body : {&free_one, static_cast<const btSoftBody*>(&cloth)}) {
    for (int c = 0; c < body->m_faceNodeContacts.size(); ++c, ++count) {
      EXPECT_GT(btFabs(body->m_faceNodeContacts[c].m_normal.y()), btScalar(0.999));
    }
  }
  EXPECT_GT(count, 0);
}

// The boxes of the body at both ends of the path leave the mesh out.
TEST_P(MovedMasslessDeformable, nodes_touch_a_mesh_between_the_ends_of_their_paths) {
  btTriangleMesh mesh = triangle(btVector3(btScalar(1.5), btScalar(-0.5), 0));
  simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&mesh, /*quantised=*/true), btVector3(0, 0, 0));
  SheetOptions options;
  options.nodes_per_side = 3;
  options.side = 4;
  options.margin = kMargin;
  btSoftBody& cloth = simulation.add(make_sheet(simulation.world_info(), options));
  cloth.setActivationState(DISABLE_DEACTIVATION);
  for (int n = 0; n < cloth.m_nodes.size(); ++n) {
    if (cloth.m_nodes[n].m_x.x() > 1) cloth.setMass(n, 0);
  }
  simulation.step_once();
  EXPECT_EQ(AnySimulation::count_contacts(cloth), 0);
  move_massless(cloth, btVector3(btScalar(-1.8), -2, 0));
  simulation.step_once();
  EXPECT_GT(AnySimulation::count_contacts(cloth), 0);
}

// Bullet then moves nodes by their velocities of the last step.
TEST_P(MovedMasslessDeformable, cloth_comes_down_on_a_ball_with_implicit_integration) {
  auto& world = dynamic_cast<btDeformableMultiBodyDynamicsWorld&>(simulation.world());
  world.setImplicit(true);
  world.setUseProjection(true);
  lay_ball();
  push_down(add_cloth(btScalar(0.7), Massless::every_second), *ball, /*speed=*/1, /*lowest=*/btScalar(0.4), 60);
}

// Bullet calls the tick callback of this world before its solver.
TEST_P(MovedMasslessDeformable, nodes_are_where_the_app_has_put_them_after_a_step_that_throws) {
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  simulation.step();
  move_massless(cloth, btVector3(0, btScalar(-0.02), 0));
  const std::vector<btVector3> places = places_of(cloth);
  {
    const Interruption interruption(simulation.world(), When::after_tick,
                                    [] { throw std::runtime_error("the app's"); });
    EXPECT_THROW(simulation.step(), std::runtime_error);
  }
  simulation.step();
  expect_at_rest(cloth, places);
}

class MovedMasslessAttached : public MovedMassless {};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedMasslessAttached, testing::Values(World::attached, World::attached_deformable),
                         world_name);

TEST_P(MovedMasslessAttached, nodes_stay_where_the_app_detaches_within_the_step) {
  for (const When when : {When::before_tick, When::after_tick, When::in_action}) {
    SCOPED_TRACE(name_of(when));
    simulation.attach_again(bullet::Settings::safe());
    btSoftBody& cloth = add_cloth(0, Massless::every_second);
    simulation.step();
    move_massless(cloth, btVector3(0, btScalar(-0.02), 0));
    const std::vector<btVector3> places = places_of(cloth);
    {
      const Interruption interruption(simulation.world(), when, [&] { simulation.detach(); });
      simulation.world().stepSimulation(kStep, /*maxSubSteps=*/0);
    }
    expect_at_rest(cloth, places);
    simulation.remove(cloth);
  }
}

// Bullet calls actions in the order in which they were added, in the deformable world when it has moved all nodes.
TEST_P(MovedMasslessAttached, nodes_stay_where_an_action_called_before_softcds_puts_them) {
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  std::vector<btVector3> places;
  const Interruption interruption(simulation.world(), When::in_action, [&] {
    move_massless(cloth, btVector3(0, btScalar(-0.02), 0));
    places = places_of(cloth);
  });
  simulation.attach_again(bullet::Settings::safe());
  simulation.step_once();
  EXPECT_EQ(places_of(cloth), places);
}

class MovedMasslessLate : public MovedMassless {};
INSTANTIATE_TEST_SUITE_P(Worlds, MovedMasslessLate, testing::Values(World::attached), world_name);

// Steps then end when the next one begins.
TEST_P(MovedMasslessLate, cloth_comes_down_on_a_ball_without_finish_step) {
  lay_ball();
  btSoftBody& cloth = add_cloth(1, Massless::every_second);
  std::vector<btVector3> places;
  for (int frame = 0; frame < 120; ++frame) {
    if (massless_nodes(cloth)[0]->m_x.y() > btScalar(0.4)) move_massless(cloth, btVector3(0, -kStep, 0));
    places = places_of(cloth);
    simulation.world().stepSimulation(kStep, /*maxSubSteps=*/0);
  }
  simulation.finish_step();
  expect_at_rest(cloth, places);
  EXPECT_EQ(count_edges({&cloth, ball}), 0U);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(MovedMasslessLate, nodes_keep_the_velocity_that_the_app_sets_before_the_step_ends) {
  btSoftBody& cloth = add_cloth(0, Massless::every_second);
  simulation.step();
  move_massless(cloth, btVector3(0, btScalar(-0.02), 0));
  simulation.world().stepSimulation(kStep, /*maxSubSteps=*/0);
  const btVector3 velocity(0, 0, 3);
  for (Node* node : massless_nodes(cloth)) node->m_v = velocity;
  simulation.finish_step();
  for (const Node* node : massless_nodes(cloth)) EXPECT_EQ(node->m_v, velocity);
}

TEST(MasslessNodePaths, of_as_many_nodes_need_no_new_memory) {
  AnySimulation simulation(World::one_line, cpu_settings());
  SheetOptions options;
  options.fixed = true;
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  const Span<btSoftBody* const> bodies = bullet::span_of(simulation.bodies());
  bullet::MasslessNodePaths paths(bullet::kClassicEnds);
  paths.end_step(bodies);

  sheet.m_sst.sdt = kStep;
  sheet.m_sst.isdt = 1 / kStep;
  const FailingAllocation failing(1);
  paths.begin_step(bodies);
  const btVector3 end = sheet.m_nodes[0].m_x;
  for (int n = 0; n < sheet.m_nodes.size(); ++n) sheet.m_nodes[n].m_x += btVector3(0, btScalar(0.1), 0);
  paths.find_moves(bodies);
  for (int n = 0; n < sheet.m_nodes.size(); ++n) sheet.m_nodes[n].m_q = sheet.m_nodes[n].m_x;  // as Bullet predicts
  paths.set_starts(bodies, kStep);
  EXPECT_EQ(sheet.m_nodes[0].m_q, end);
  paths.end_paths(bodies);
  EXPECT_NO_THROW(paths.end_step(bodies));
}

}  // namespace
}  // namespace softcd::test
