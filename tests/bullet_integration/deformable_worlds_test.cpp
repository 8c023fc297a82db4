// Simulations in the deformable world that run for a while: bodies come to rest where they should.

#include <gtest/gtest.h>

#include <iostream>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "deformable_support.hpp"

namespace softcd::test {
namespace {

using demo::DeformableSimulation;
using MaybeSettings = std::optional<bullet::Settings>;

btScalar kinetic_energy(const btSoftBody& body) {
  btScalar energy = 0;
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btSoftBody::Node& node = body.m_nodes[n];
    if (node.m_im > 0) energy += node.m_v.length2() / (2 * node.m_im);
  }
  return energy;
}

struct RestOfWorld {
  btScalar height = 0;
  btScalar energy = 0;
  int below = 0;
};

void print(const char* scene, const RestOfWorld& bullets, const RestOfWorld& ours) {
  std::cout << scene << ", Bullet and softcd: mean height " << bullets.height << ", " << ours.height
            << "; kinetic energy " << bullets.energy << ", " << ours.energy << "; nodes on the wrong side "
            << bullets.below << ", " << ours.below << "\n";
}

// Bullet moves the nodes of the deformable world explicitly: short steps.
constexpr btScalar kShortStep = btScalar(1) / 240;

/// Sheets fall onto a held one, and onto each other.
RestOfWorld stacked_cloths(const MaybeSettings& settings, int layers) {
  DeformableSimulation simulation(settings);
  SheetOptions options;
  options.margin = btScalar(0.02);
  options.side = btScalar(1.4);
  options.nodes_per_side = 13;
  options.fixed = true;
  btSoftBody* below = &simulation.add(make_sheet(simulation.world_info(), options));
  options.fixed = false;
  options.side = 1;
  std::vector<btSoftBody*> sheets;
  for (int layer = 0; layer < layers; ++layer) {
    options.nodes_per_side = 10 + layer % 2;
    options.height = btScalar(0.1) * btScalar(layer + 1);
    sheets.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
  }
  for (int step = 0; step < 360; ++step) simulation.step(kShortStep);
  RestOfWorld rest;
  for (btSoftBody* sheet : sheets) {
    rest.below += count_below(*sheet, *below);
    rest.energy += kinetic_energy(*sheet);
    below = sheet;
  }
  rest.height = mean_height(*sheets.back());
  return rest;
}

TEST(DeformableWorld, a_cloth_rests_on_another_as_with_bullet) {
  const RestOfWorld bullets = stacked_cloths(std::nullopt, 1);
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const RestOfWorld ours = stacked_cloths(test_settings(detection), 1);
    print("a cloth on another", bullets, ours);
    EXPECT_EQ(ours.below, 0);
    EXPECT_NEAR(ours.height, bullets.height, 0.01);
    EXPECT_LT(ours.energy, 0.02);
  }
}

TEST(DeformableWorld, cloths_stack) {
  const RestOfWorld bullets = stacked_cloths(std::nullopt, 4);
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const RestOfWorld ours = stacked_cloths(test_settings(detection), 4);
    print("four cloths", bullets, ours);
    if (detection == Detection::ccd) {
      EXPECT_EQ(ours.below, 0);
    }
    EXPECT_NEAR(ours.height, bullets.height, 0.03);
  }
}

/// A strip folded once; the lower half is held.
RestOfWorld folded_strip(const MaybeSettings& settings, bool self_collision) {
  DeformableSimulation simulation(settings);
  demo::ClothShape shape;
  shape.columns = 33;
  shape.rows = 9;
  const btScalar spacing = btScalar(0.1);
  const auto is_upper = [](int column) { return column > 18; };
  shape.position = [&](int column, int row) {
    const btScalar z = spacing * btScalar(row);
    if (column < 14) return btVector3(spacing * btScalar(column), 0, z);
    if (is_upper(column)) return btVector3(spacing * btScalar(32 - column), btScalar(0.12), z);
    const btScalar angle = SIMD_PI * btScalar(column - 13) / 6;
    return btVector3(spacing * 13 + btScalar(0.06) * btSin(angle), btScalar(0.06) * (1 - btCos(angle)), z);
  };
  shape.is_fixed = [](int column, int) { return column < 14; };
  auto strip = demo::make_cloth(simulation.world_info(), shape, 1);
  strip->getCollisionShape()->setMargin(btScalar(0.025));
  strip->setSelfCollision(self_collision);
  const btSoftBody& body = simulation.add(std::move(strip));
  for (int step = 0; step < 360; ++step) simulation.step(kShortStep);
  RestOfWorld rest;
  int count = 0;
  for (int column = 20; column < 33; ++column) {
    for (int row = 0; row < 9; ++row) {
      const btVector3& x = body.m_nodes[row * 33 + column].m_x;
      rest.height += x.y();
      const bool is_over_lower_half = x.x() > 0 && x.x() < 13 * spacing && x.z() > 0 && x.z() < 8 * spacing;
      rest.below += is_over_lower_half && x.y() < 0;
      ++count;
    }
  }
  rest.height /= btScalar(count);
  rest.energy = kinetic_energy(body);
  return rest;
}

TEST(DeformableWorld, a_folded_strip_rests_on_itself) {
  const RestOfWorld bullets = folded_strip(std::nullopt, true);
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const RestOfWorld ours = folded_strip(test_settings(detection), true);
    print("folded strip", bullets, ours);
    EXPECT_EQ(ours.below, 0);
    EXPECT_NEAR(ours.height, 0.05, 0.01) << "twice the margin";
  }
  EXPECT_LT(folded_strip(test_settings(), false).height, -0.3) << "without self-collision";
}

RestOfWorld ball_on_box_and_cloth(const MaybeSettings& settings) {
  DeformableSimulation simulation(settings);
  simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(2, btScalar(0.5), 2)), btVector3(0, btScalar(-0.5), 0));
  SheetOptions options;
  options.margin = btScalar(0.02);
  options.height = btScalar(0.1);
  const btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  auto ball = make_soft_ball(simulation.world_info(), btVector3(0, btScalar(0.5), 0), btScalar(0.25));
  ball->getCollisionShape()->setMargin(options.margin);
  btSoftBody& thrown = simulation.add(std::move(ball));
  for (int step = 0; step < 240; ++step) simulation.step(kShortStep);
  return {mean_height(sheet), kinetic_energy(thrown), count_below(thrown, sheet)};
}

TEST(DeformableWorld, a_cloth_lies_on_a_rigid_box_under_a_ball_as_with_bullet) {
  const RestOfWorld bullets = ball_on_box_and_cloth(std::nullopt);
  const RestOfWorld ours = ball_on_box_and_cloth(test_settings());
  print("cloth on a box, under a ball", bullets, ours);
  EXPECT_NEAR(ours.height, bullets.height, 0.01);
  EXPECT_GT(ours.height, 0);
}

TEST(DeformableWorld, the_backend_under_test_detects) {
  DeformableSimulation simulation(test_settings());
  for (int sheet = 0; sheet < 2; ++sheet) simulation.add(make_sheet(simulation.world_info(), {}));
  simulation.step(kStep);
  const Statistics statistics = simulation.detection()->contact_report().statistics();
  EXPECT_GT(statistics.vt_contacts, 0U);
  EXPECT_EQ(statistics.backend, backend_under_test());
}

}  // namespace
}  // namespace softcd::test
