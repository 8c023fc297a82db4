// Bodies under pressure in classic worlds with continuous detection. Bullet predicts that they burst in every step.

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "any_simulation.hpp"
#include "backend_under_test.hpp"
#include "scenes/cloth.hpp"

namespace softcd::test {
namespace {

constexpr btScalar kRadius = btScalar(0.25);
constexpr int kIterations = 10;

bullet::Settings safe_settings() {
  bullet::Settings settings = bullet::Settings::safe();
  settings.backend = backend_under_test();
  return settings;
}

/// A cloth of one kilogram and a ball under pressure.
class PressedBodies {
 public:
  PressedBodies(World world, const std::optional<bullet::Settings>& settings, btScalar margin)
      : simulation(world, settings), margin_(margin) {}

  btSoftBody& add_cloth(btScalar height) {
    return add(demo::make_cloth(simulation.world_info(), demo::horizontal_cloth(14, btScalar(1.6), height), 1));
  }

  btSoftBody& add_ball(btScalar height) {
    const btVector3 center(0, height, 0);
    std::unique_ptr<btSoftBody> ball(btSoftBodyHelpers::CreateEllipsoid(
        simulation.world_info(), center, btVector3(kRadius, kRadius, kRadius), /*res=*/128));
    ball->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
    ball->m_cfg.kPR = 20;
    ball->m_cfg.kDF = btScalar(0.5);
    ball->setTotalMass(btScalar(0.5), /*fromfaces=*/true);
    return add(std::move(ball));
  }

  AnySimulation simulation;

 private:
  btSoftBody& add(std::unique_ptr<btSoftBody> body) {
    body->m_cfg.piterations = kIterations;
    body->getCollisionShape()->setMargin(margin_);
    return simulation.add(std::move(body));
  }

  btScalar margin_;
};

/// Returns the greatest kinetic energy of two seconds in which the ball falls from `height` on the cloth, which lies on
/// a static mesh. The ball brings less than 2 J.
btScalar most_energy(World world, const std::optional<bullet::Settings>& settings, btScalar margin, btScalar height) {
  btTriangleMesh ground;
  constexpr int kCells = 16;
  const auto corner = [](int x, int z) { return btVector3(btScalar(x) / 4 - 2, 0, btScalar(z) / 4 - 2); };
  for (int x = 0; x < kCells; ++x) {
    for (int z = 0; z < kCells; ++z) {
      ground.addTriangle(corner(x, z), corner(x, z + 1), corner(x + 1, z));
      ground.addTriangle(corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1));
    }
  }
  PressedBodies bodies(world, settings, margin);
  bodies.simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&ground, true), btVector3(0, 0, 0))
      .setFriction(1);
  const btSoftBody& cloth = bodies.add_cloth(btScalar(0.05));
  const btSoftBody& ball = bodies.add_ball(height);
  btScalar most = 0;
  int contacts = 0;
  for (int step = 0; step < 120; ++step) {
    bodies.simulation.step();
    most = btMax(most, kinetic_energy(cloth) + kinetic_energy(ball));
    contacts += ball.m_scontacts.size() + cloth.m_scontacts.size();
  }
  EXPECT_GT(contacts, 0);
  return most;
}

class Pressure : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, Pressure, testing::Values(World::one_line, World::multi_body, World::attached),
                         world_name);

TEST_P(Pressure, does_not_draw_bodies_to_others) {
  PressedBodies bodies(GetParam(), safe_settings(), /*margin=*/btScalar(0.005));
  bodies.simulation.set_gravity(btVector3(0, 0, 0));
  bodies.add_cloth(0);
  const btScalar gap = btScalar(0.03);
  const btSoftBody& ball = bodies.add_ball(kRadius + gap);
  for (int step = 0; step < 30; ++step) bodies.simulation.step();
  EXPECT_GT(lowest_height(ball), gap - btScalar(0.01));
}

TEST_P(Pressure, gives_no_energy_to_bodies_that_press) {
  EXPECT_LT(most_energy(GetParam(), safe_settings(), /*margin=*/btScalar(0.02), /*height=*/btScalar(0.5)), 20);
}

// With small margins the energy varies from start to start.
TEST(SmallMargins, give_bodies_under_pressure_less_energy_than_with_bullet_alone) {
  const auto median = [](const std::optional<bullet::Settings>& settings) {
    std::vector<btScalar> energies;
    for (int start = 0; start < 5; ++start) {
      const btScalar height = btScalar(0.5) + btScalar(1e-3) * btScalar(start);
      energies.push_back(most_energy(World::one_line, settings, /*margin=*/btScalar(0.005), height));
    }
    std::sort(energies.begin(), energies.end());
    return energies[energies.size() / 2];
  };
  EXPECT_LT(median(safe_settings()), median(std::nullopt));
}

}  // namespace
}  // namespace softcd::test
