// Simulations in the deformable world that run for a while: bodies come to rest where they should.

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "any_simulation.hpp"
#include "scenes/penetration.hpp"

namespace softcd::test {
namespace {

using demo::DeformableSimulation;
using MaybeSettings = std::optional<bullet::Settings>;

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

// Bullet solves contacts in an order that differs from run to run. So does the strip's height, by more than the bound
// in one run of twenty.
TEST(DeformableWorld, a_folded_strip_rests_on_itself) {
  const RestOfWorld bullets = folded_strip(std::nullopt, true);
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    std::vector<btScalar> heights;
    for (int run = 0; run < 3; ++run) {
      const RestOfWorld ours = folded_strip(test_settings(detection), true);
      print("folded strip", bullets, ours);
      EXPECT_EQ(ours.below, 0);
      heights.push_back(ours.height);
    }
    std::sort(heights.begin(), heights.end());
    EXPECT_NEAR(heights[1], 0.05, 0.01) << "twice the margin";
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

/// Throws a free sheet at two free ones with a held one behind them: so fast that it would be through the next after a
/// step. The sheets have different nodes. Returns the edges that pass through triangles, in the sum of all steps.
std::size_t throw_at_sheets(World world, const MaybeSettings& settings, btScalar speed) {
  AnySimulation simulation(world, settings);
  simulation.set_gravity(btVector3(0, 0, 0));
  std::vector<const btSoftBody*> sheets;
  for (int i = 0; i < 4; ++i) {
    SheetOptions options;
    options.nodes_per_side = 9 - i % 2;
    options.height = btScalar(0.035) * btScalar(i);
    options.margin = btScalar(0.02);
    options.fixed = i == 3;
    btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
    sheet.translate(btVector3(btScalar(0.03), 0, btScalar(0.02)) * btScalar(i));
    if (i == 0) sheet.setVelocity(btVector3(0, speed, 0));
    sheets.push_back(&sheet);
  }
  std::size_t intersections = 0;
  for (int step = 0; step < 24; ++step) {
    simulation.step_once();
    intersections += demo::find_intersections(sheets).edge_count;
  }
  for (std::size_t i = 1; i < 4 && settings.has_value(); ++i) {
    EXPECT_LT(mean_height(*sheets[i - 1]), mean_height(*sheets[i])) << name_of(world);
  }
  return intersections;
}

// Bullet repeats its response up to five times while nodes would pass through faces, and softcd does, too. If it
// repeated it once, the sum would be a tenth of Bullet's.
TEST(DeformableWorld, sheets_thrown_at_each_other_hardly_pass) {
  constexpr btScalar kSpeed = 20;
  const std::size_t bullets = throw_at_sheets(World::deformable, std::nullopt, kSpeed);
  for (const World world : {World::deformable, World::attached_deformable}) {
    for (const bullet::ReadOut read_out : {bullet::ReadOut::off, bullet::ReadOut::impulses}) {
      bullet::Settings settings = test_settings();
      settings.read_out = read_out;
      const std::size_t ours = throw_at_sheets(world, settings, kSpeed);
      EXPECT_LE(20 * ours, bullets) << name_of(world);
      std::cout << "thrown sheets, Bullet and softcd: " << bullets << ", " << ours << "\n";
    }
  }
}

/// Throws a box onto three sheets that lie on a floor. Returns the sum of the intersections over all steps.
std::size_t throw_box_at_sheets(World world, const MaybeSettings& settings, btScalar mass) {
  AnySimulation simulation(world, settings);
  simulation.set_gravity(btVector3(0, -10, 0));
  simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(3, btScalar(0.5), 3)), btVector3(0, btScalar(-0.5), 0));
  const btScalar half = btScalar(0.15);
  btRigidBody& box = simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(half, half, half)),
                                          btVector3(0, btScalar(0.17) + half, 0), mass);
  box.setLinearVelocity(btVector3(0, -3, 0));
  std::vector<const btSoftBody*> sheets;
  for (int i = 0; i < 3; ++i) {
    SheetOptions options;
    options.nodes_per_side = 13;
    options.margin = btScalar(0.02);
    options.height = btScalar(0.04) * btScalar(i + 1);
    btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
    sheet.setTotalMass(btScalar(0.3));
    sheets.push_back(&sheet);
  }
  std::size_t intersections = 0;
  for (int step = 0; step < 60; ++step) {
    simulation.step_once();
    intersections += demo::find_intersections(sheets).edge_count;
  }
  return intersections;
}

// Bullet leaves nodes that touch the box their velocity, and pushes the sheet below twice as hard: momentum from
// nothing.
TEST(DeformableWorld, a_box_pushes_sheets_less_through_each_other_than_with_bullet) {
  for (const auto& [mass, fewer] : {std::pair(btScalar(0.2), 20), std::pair(btScalar(2), 3)}) {
    const std::size_t bullets = throw_box_at_sheets(World::deformable, std::nullopt, mass);
    for (const World world : {World::deformable, World::attached_deformable}) {
      for (const bullet::ReadOut read_out : {bullet::ReadOut::off, bullet::ReadOut::impulses}) {
        bullet::Settings settings = test_settings();
        settings.read_out = read_out;
        const std::size_t ours = throw_box_at_sheets(world, settings, mass);
        std::cout << "below a box of " << mass << " kg, Bullet and softcd: " << bullets << ", " << ours << "\n";
        EXPECT_LE(fewer * ours, bullets) << name_of(world);
      }
    }
  }
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
