// The last pass stops nodes that Bullet's solver has moved with others. It stretches no link without a bound.

#include "crossings/link_stretch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "any_simulation.hpp"
#include "native/arrays.hpp"
#include "scenes/surface_mesh.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

/// A link of length 1 whose nodes move apart along x, in a step of one second. A mass of 0 holds a node.
struct MovedLink {
  btSoftBodyWorldInfo world_info;
  std::unique_ptr<btSoftBody> body;
  bullet::AnsweredBodies answered;

  MovedLink(const btScalar (&masses)[2], btScalar length_at_start, btScalar solved_length) {
    const btVector3 places[] = {btVector3(0, 0, 0), btVector3(1, 0, 0)};
    body = std::make_unique<btSoftBody>(&world_info, 2, places, masses);
    body->appendLink(0, 1);
    body->m_nodes[1].m_q = btVector3(length_at_start, 0, 0);
    answered.add(*body)->ends = {btVector3(0, 0, 0), btVector3(solved_length, 0, 0)};
  }
  bool limit_stretch(btScalar velocity_a, btScalar velocity_b) {
    body->m_nodes[0].m_v = btVector3(velocity_a, 0, 0);
    body->m_nodes[1].m_v = btVector3(velocity_b, 0, 0);
    return bullet::limit_stretch(answered, /*time_step=*/1);
  }
  btScalar velocity(int node) const { return body->m_nodes[node].m_v.x(); }
  btScalar length_at_end() const { return body->m_nodes[1].m_q.x() + velocity(1) - velocity(0); }
};

TEST(LinkStretch, is_limited_to_twice_the_rest_length_by_impulses_within_the_body) {
  MovedLink link({1, 3}, /*length_at_start=*/1, /*solved_length=*/1);
  EXPECT_TRUE(link.limit_stretch(-1, 4));
  EXPECT_NEAR(link.length_at_end(), 2, 1e-5);
  EXPECT_NEAR(link.velocity(0) + 3 * link.velocity(1), -1 + 3 * 4, 1e-5);
  EXPECT_FALSE(link.limit_stretch(0, btScalar(0.9)));
  EXPECT_EQ(link.velocity(1), btScalar(0.9));
}

TEST(LinkStretch, may_stay_as_great_as_at_the_start_and_as_the_solver_leaves_it) {
  MovedLink stretched({1, 1}, /*length_at_start=*/5, /*solved_length=*/1);
  EXPECT_FALSE(stretched.limit_stretch(0, 0));
  EXPECT_TRUE(stretched.limit_stretch(0, 1));
  EXPECT_NEAR(stretched.length_at_end(), 5, 1e-5);
  MovedLink solved({1, 1}, /*length_at_start=*/1, /*solved_length=*/4);
  EXPECT_TRUE(solved.limit_stretch(0, 5));
  EXPECT_NEAR(solved.length_at_end(), 4, 1e-5);
}

TEST(LinkStretch, moves_no_node_without_mass) {
  MovedLink one_held({0, 1}, /*length_at_start=*/1, /*solved_length=*/1);
  EXPECT_TRUE(one_held.limit_stretch(-4, 0));
  EXPECT_EQ(one_held.velocity(0), -4);
  EXPECT_NEAR(one_held.length_at_end(), 2, 1e-5);
  MovedLink both_held({0, 0}, /*length_at_start=*/1, /*solved_length=*/1);
  EXPECT_FALSE(both_held.limit_stretch(-4, 0));
}

/// A ring around y: a static mesh, with a hole that is narrower than the cloth.
class Ring {
 public:
  Ring() {
    std::vector<demo::ProfilePoint> circle;
    constexpr int kCorners = 10;
    for (int i = 0; i <= kCorners; ++i) {
      const btScalar angle = SIMD_2_PI * btScalar(i % kCorners) / kCorners;
      circle.push_back({btScalar(0.35) + btScalar(0.06) * btCos(angle), btScalar(0.06) * btSin(angle)});
    }
    const demo::SurfaceMesh mesh = demo::lathe_mesh(circle, 24);
    for (const auto& [a, b, c] : mesh.triangles) {
      triangles_.addTriangle(mesh.positions[static_cast<std::size_t>(a)], mesh.positions[static_cast<std::size_t>(b)],
                             mesh.positions[static_cast<std::size_t>(c)]);
    }
  }
  std::unique_ptr<btCollisionShape> shape() {
    auto shape = std::make_unique<btBvhTriangleMeshShape>(&triangles_, true);
    shape->setMargin(btScalar(0.02));
    return shape;
  }

 private:
  btTriangleMesh triangles_;
};

/// Returns the greatest kinetic energy of two seconds in which a cloth of 0.5 kg lies on the ring, and a node of 1 kg
/// pulls its middle down. A fall of four metres would give it 60 J.
btScalar most_energy(World world, const bullet::Settings& settings, int iterations, btScalar shift) {
  Ring ring;
  AnySimulation simulation(world, settings);
  simulation.add_rigid(ring.shape(), btVector3(0, 0, 0));
  constexpr int kNodes = 21;
  const auto corner = [&](int x, int z) {
    return btVector3(btScalar(0.7) * btScalar(x) + shift, btScalar(0.2), btScalar(0.7) * btScalar(z) - shift / 2);
  };
  std::unique_ptr<btSoftBody> made(btSoftBodyHelpers::CreatePatch(
      simulation.world_info(), corner(-1, -1), corner(1, -1), corner(-1, 1), corner(1, 1), kNodes, kNodes, 0,
      /*gendiags=*/true));
  made->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  made->setTotalMass(btScalar(0.5));
  made->generateBendingConstraints(2);
  made->setMass(kNodes * kNodes / 2, 1);
  made->getCollisionShape()->setMargin(btScalar(0.015));
  made->m_cfg.piterations = iterations;
  made->m_cfg.kDF = btScalar(0.3);
  made->setSelfCollision(true);
  const btSoftBody& cloth = simulation.add(std::move(made));
  btScalar most = 0;
  for (int frame = 0; frame < 120; ++frame) {
    simulation.step();
    most = std::max(most, kinetic_energy(cloth));
  }
  return most;
}

TEST(LinkStretch, does_not_throw_a_cloth_that_is_pulled_through_a_ring) {
  for (const World world : kClassicLookingWorlds) {
    for (const bullet::Settings& settings : {bullet::Settings::balanced(), bullet::Settings::safe()}) {
      for (const btScalar shift : {btScalar(0), btScalar(1.5e-3)}) {
        SCOPED_TRACE("world " + std::to_string(int(world)) + ", shift " + std::to_string(shift));
        EXPECT_LT(most_energy(world, settings, /*iterations=*/1, shift), 60);
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test
