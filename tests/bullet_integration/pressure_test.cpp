// Bodies under pressure in classic worlds with continuous detection. Bullet predicts that they burst in every step.

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

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

class Pressure : public testing::TestWithParam<World> {
 protected:
  /// A cloth of one kilogram.
  btSoftBody& add_cloth(btScalar height, btScalar margin) {
    return add(demo::make_cloth(simulation.world_info(), demo::horizontal_cloth(14, btScalar(1.6), height), 1), margin);
  }

  btSoftBody& add_ball(btScalar height, btScalar margin) {
    const btVector3 center(0, height, 0);
    std::unique_ptr<btSoftBody> ball(btSoftBodyHelpers::CreateEllipsoid(
        simulation.world_info(), center, btVector3(kRadius, kRadius, kRadius), /*res=*/128));
    ball->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
    ball->m_cfg.kPR = 20;
    ball->m_cfg.kDF = btScalar(0.5);
    ball->setTotalMass(btScalar(0.5), /*fromfaces=*/true);
    return add(std::move(ball), margin);
  }

  AnySimulation simulation{GetParam(), safe_settings()};

 private:
  btSoftBody& add(std::unique_ptr<btSoftBody> body, btScalar margin) {
    body->m_cfg.piterations = kIterations;
    body->getCollisionShape()->setMargin(margin);
    return simulation.add(std::move(body));
  }
};

INSTANTIATE_TEST_SUITE_P(Worlds, Pressure, testing::Values(World::one_line, World::multi_body, World::attached),
                         world_name);

TEST_P(Pressure, does_not_draw_bodies_to_others) {
  simulation.set_gravity(btVector3(0, 0, 0));
  const btScalar margin = btScalar(0.005);
  add_cloth(0, margin);
  const btScalar gap = btScalar(0.03);
  const btSoftBody& ball = add_ball(kRadius + gap, margin);
  for (int step = 0; step < 30; ++step) simulation.step();
  EXPECT_GT(lowest_height(ball), gap - btScalar(0.01));
}

TEST_P(Pressure, gives_no_energy_to_bodies_that_press) {
  btTriangleMesh ground;
  constexpr int kCells = 16;
  const auto corner = [](int x, int z) { return btVector3(btScalar(x) / 4 - 2, 0, btScalar(z) / 4 - 2); };
  for (int x = 0; x < kCells; ++x) {
    for (int z = 0; z < kCells; ++z) {
      ground.addTriangle(corner(x, z), corner(x, z + 1), corner(x + 1, z));
      ground.addTriangle(corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1));
    }
  }
  simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&ground, true), btVector3(0, 0, 0)).setFriction(1);
  const btScalar margin = btScalar(0.02);
  const btSoftBody& cloth = add_cloth(btScalar(0.05), margin);
  const btSoftBody& ball = add_ball(btScalar(0.5), margin);
  btScalar most = 0;
  int contacts = 0;
  for (int step = 0; step < 120; ++step) {
    simulation.step();
    most = btMax(most, kinetic_energy(cloth) + kinetic_energy(ball));
    contacts += ball.m_scontacts.size() + cloth.m_scontacts.size();
  }
  EXPECT_GT(contacts, 0);
  EXPECT_LT(most, 20) << "joules. The ball brings less than 2.";
}

}  // namespace
}  // namespace softcd::test
