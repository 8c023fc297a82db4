// A cloth that collides with itself tumbles in a closed box, a rigid triangle mesh, as if the box were turned: gravity
// turns once in four seconds. No step ends with the cloth through itself, or through the box.

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"
#include "rigid_intersections.hpp"
#include "scenes/penetration.hpp"

#ifndef SOFTCD_TUMBLING_STEPS
#define SOFTCD_TUMBLING_STEPS 200
#endif

namespace softcd::test {
namespace {

constexpr int kTumblingSteps = SOFTCD_TUMBLING_STEPS;  ///< of a sixtieth of a second
constexpr btScalar kHalfSide = btScalar(0.7);
constexpr btScalar kGravity = 10;

RigidTriangles box_triangles() {
  RigidTriangles triangles;
  for (int axis = 0; axis < 3; ++axis) {
    for (const btScalar side : {-kHalfSide, kHalfSide}) {
      btVector3 u(0, 0, 0), v(0, 0, 0), center(0, 0, 0);
      center[axis] = side;
      u[(axis + 1) % 3] = kHalfSide;
      v[(axis + 2) % 3] = kHalfSide;
      triangles.push_back({center - u - v, center + u - v, center + u + v});
      triangles.push_back({center - u - v, center + u + v, center - u + v});
    }
  }
  return triangles;
}

std::unique_ptr<btTriangleMesh> mesh_of(const RigidTriangles& triangles) {
  auto mesh = std::make_unique<btTriangleMesh>();
  for (const auto& [a, b, c] : triangles) mesh->addTriangle(a, b, c);
  return mesh;
}

/// The result of all steps.
struct Tumbling {
  std::size_t most_edges = 0;         ///< that intersect triangles after a step
  std::size_t most_edges_in_box = 0;  ///< of the cloth or of the box in the other
  long steps_with_edges = 0;
  btScalar farthest_out = -1;  ///< of the box, of a node, m
  long steps_in_touch = 0;     ///< with itself, within its margins
  long answered_steps = 0;
  std::uint64_t rounds = 0, most_rounds = 0, unavoidable = 0, excepted = 0;
  double most_energy = 0;  ///< kinetic, J
  double most_given = 0;   ///< by the responses of one step, J
};

class TumblingCloth : public testing::TestWithParam<World> {
 protected:
  TumblingCloth() : triangles(box_triangles()), box(mesh_of(triangles)), simulation(GetParam(), settings()) {
    auto walls = std::make_unique<btBvhTriangleMeshShape>(box.get(), true);
    simulation.add_rigid(std::move(walls), btVector3(0, 0, 0));
    SheetOptions options;
    options.nodes_per_side = 10;
    options.side = btScalar(0.6);
    options.margin = btScalar(0.016);
    cloth = &simulation.add(make_sheet(simulation.world_info(), options));
    cloth->m_cfg.kKHR = 1;
    cloth->setSelfCollision(true);
    cloth->setActivationState(DISABLE_DEACTIVATION);
  }

  static bullet::Settings settings() {
    bullet::Settings settings = careful_settings();
    return settings;
  }

  void tumble(int steps) {
    for (int step = 0; step < steps; ++step) {
      simulation.step([&](btScalar seconds) {
        see_answers();
        turn_gravity(seconds);
      });
      see_answers();
      const std::size_t edges = demo::find_intersections({cloth}).edge_count;
      seen.most_edges = std::max(seen.most_edges, edges);
      seen.steps_with_edges += edges > 0 ? 1 : 0;
      const std::size_t edges_in_box = count_intersections(*cloth, triangles);
      seen.most_edges_in_box = std::max(seen.most_edges_in_box, edges_in_box);
      see_nodes();
    }
  }

  /// Which the worlds have downward.
  void turn_gravity(btScalar seconds) {
    time += seconds;
    const btScalar angle = time * SIMD_HALF_PI;
    const btVector3 change(kGravity * btSin(angle), kGravity * (1 - btCos(angle)), 0);
    for (int n = 0; n < cloth->m_nodes.size(); ++n) cloth->m_nodes[n].m_v += change * seconds;
  }

  void see_answers() {
    const bullet::CrossingAnswers answers = simulation.detection().crossing_answers();
    seen.answered_steps += answers.rounds > 0 ? 1 : 0;
    seen.rounds += answers.rounds;
    seen.most_rounds = std::max(seen.most_rounds, answers.rounds);
    seen.unavoidable += answers.unavoidable;
    seen.excepted += answers.excepted;
    seen.most_given = std::max(seen.most_given, answers.energy);
  }

  /// Along the axis along which it is farthest.
  btScalar distance_of_center() const {
    btVector3 center(0, 0, 0);
    for (int n = 0; n < cloth->m_nodes.size(); ++n) center += cloth->m_nodes[n].m_x / btScalar(cloth->m_nodes.size());
    center = center.absolute();
    return center[center.maxAxis()];
  }

  void see_nodes() {
    double energy = 0;
    for (int n = 0; n < cloth->m_nodes.size(); ++n) {
      const btSoftBody::Node& node = cloth->m_nodes[n];
      energy += double(node.m_v.length2()) / double(node.m_im) / 2;
      const btVector3 x = node.m_x.absolute();
      seen.farthest_out = btMax(seen.farthest_out, x[x.maxAxis()] - kHalfSide);
    }
    seen.most_energy = std::max(seen.most_energy, energy);
    seen.steps_in_touch += simulation.detection().contact_report().statistics().vt_contacts > 0 ? 1 : 0;
  }

  RigidTriangles triangles;
  std::unique_ptr<btTriangleMesh> box;
  AnySimulation simulation;
  btSoftBody* cloth = nullptr;
  btScalar time = 0;
  Tumbling seen;
};
INSTANTIATE_TEST_SUITE_P(Worlds, TumblingCloth, testing::Values(World::one_line, World::deformable), world_name);

TEST_P(TumblingCloth, is_never_through_itself) {
  tumble(kTumblingSteps);
  const double mean_rounds = double(seen.rounds) / double(std::max(1L, seen.answered_steps));
  std::cout << kTumblingSteps << " steps: " << seen.steps_with_edges << " with edges in triangles, at most "
            << seen.most_edges << "; answers in " << seen.answered_steps << ", rounds " << mean_rounds << ", most "
            << seen.most_rounds << "; energy up to " << seen.most_energy << " J, given by one step's answers up to "
            << seen.most_given << " J; in touch with itself in " << seen.steps_in_touch << "; edges in the box "
            << seen.most_edges_in_box << ", nodes out of it by up to " << seen.farthest_out << " m\n";
  EXPECT_EQ(seen.most_edges, 0U);
  EXPECT_EQ(seen.most_edges_in_box, 0U);
  EXPECT_LT(seen.farthest_out, 0);
  EXPECT_EQ(seen.unavoidable, 0U);
  EXPECT_EQ(seen.excepted, 0U);
  EXPECT_LT(distance_of_center(), kHalfSide) << "it is still in the box";
  EXPECT_GT(seen.steps_in_touch, kTumblingSteps / 5);
  EXPECT_LT(seen.most_given, 1e-6);
}

}  // namespace
}  // namespace softcd::test
