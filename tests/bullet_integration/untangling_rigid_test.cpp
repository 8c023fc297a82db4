// Soft bodies that intersect rigid meshes and convex shapes, with Settings::untangle.

#include <gtest/gtest.h>

#include <memory>
#include <tuple>
#include <vector>

#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "untangling_support.hpp"

namespace softcd::test {
namespace {

class UntanglingLaterMeshes : public testing::TestWithParam<std::tuple<World, Detection>> {
 protected:
  void shift_cloth(btScalar distance) { shift(cloth, btVector3(distance, 0, 0)); }
  void sleep(int steps) {
    for (int n = 0; n < cloth.m_nodes.size(); ++n) {
      cloth.m_nodes[n].m_v.setZero();
      cloth.m_nodes[n].m_splitv.setZero();
    }
    cloth.forceActivationState(ISLAND_SLEEPING);
    for (int i = 0; i < steps; ++i) tangle.step();
    cloth.forceActivationState(ACTIVE_TAG);
  }
  void expect_to_part() {
    ASSERT_GT(tangle.edges(), 0U);
    int steps = 0;
    for (; steps < kMostSteps && tangle.edges() > 0; ++steps) tangle.step();
    EXPECT_LT(steps, kMostSteps);
  }
  void expect_to_stay() {
    for (int i = 0; i < 40; ++i) {
      tangle.step();
      EXPECT_TRUE(tangle.pairs().empty()) << "step " << i;
    }
    EXPECT_GT(tangle.edges(), 0U);
  }

  Tangle tangle{"cloth-in-mesh", std::get<World>(GetParam()),
                untangling(std::get<Detection>(GetParam()), bullet::Untangle::later)};
  btSoftBody& cloth = *tangle.simulation().bodies()[0];
};

TEST_P(UntanglingLaterMeshes, parts_a_body_from_a_mesh_that_it_meets_after_the_first_step) {
  shift_cloth(5);
  tangle.simulation().step_once();
  shift_cloth(-5);
  expect_to_part();
}

TEST_P(UntanglingLaterMeshes, parts_a_body_that_has_met_a_mesh_and_slept) {
  shift_cloth(5);
  tangle.simulation().step_once();
  shift_cloth(-5);
  for (int i = 0; i < 2; ++i) tangle.step();
  ASSERT_EQ(tangle.pairs().size(), 1U);
  sleep(5);
  expect_to_part();
}

TEST_P(UntanglingLaterMeshes, leaves_a_body_that_has_slept_where_the_app_has_placed_it) {
  for (int i = 0; i < 5; ++i) tangle.step();
  sleep(5);
  expect_to_stay();
}

TEST_P(UntanglingLaterMeshes, leaves_a_mesh_that_is_added_into_a_body) {
  btRigidBody& mesh = *tangle.rigid_bodies()[0];
  btDiscreteDynamicsWorld& world = tangle.simulation().world();
  world.removeRigidBody(&mesh);
  for (int i = 0; i < 5; ++i) tangle.step();
  world.addRigidBody(&mesh);
  expect_to_stay();
}

INSTANTIATE_TEST_SUITE_P(InEveryWorld, UntanglingLaterMeshes,
                         testing::Combine(kLookingWorlds, testing::Values(Detection::dcd, Detection::ccd)),
                         name_of_later);

class UntanglingConvex : public testing::TestWithParam<World> {};

/// Bullet's own contacts know the inside of a convex shape, and lead nodes out of it, slowly.
TEST_P(UntanglingConvex, is_left_to_bullets_own_contacts) {
  Tangle tangle("cloth-in-mesh", GetParam(), untangling(Detection::dcd), /*has_meshes=*/false);
  const btVector3 center(btScalar(0.05), btScalar(0.15), btScalar(0.02));
  constexpr btScalar kRadius = btScalar(0.25);
  tangle.simulation().add_rigid(std::make_unique<btSphereShape>(kRadius), center);
  const auto inside = [&] {
    const btSoftBody& cloth = *tangle.simulation().bodies()[0];
    int count = 0;
    for (int n = 0; n < cloth.m_nodes.size(); ++n) count += cloth.m_nodes[n].m_x.distance(center) < kRadius ? 1 : 0;
    return count;
  };
  const int first = inside();
  for (int i = 0; i < 60; ++i) tangle.step();
  EXPECT_TRUE(tangle.pairs().empty());
  EXPECT_LT(4 * inside(), 3 * first);
  EXPECT_LT(tangle.fastest(), 1);
}

INSTANTIATE_TEST_SUITE_P(InBothKinds, UntanglingConvex, testing::Values(World::one_line, World::deformable),
                         world_name);

class UntanglingMeshes : public testing::TestWithParam<World> {};

TEST_P(UntanglingMeshes, are_reported) {
  Tangle tangle("cloth-in-mesh", GetParam(), untangling(Detection::dcd));
  tangle.simulation().step_once();
  ASSERT_EQ(tangle.pairs().size(), 1U);
  EXPECT_EQ(tangle.pairs()[0].a, tangle.simulation().bodies()[0]);
  EXPECT_EQ(tangle.pairs()[0].b, tangle.rigid_bodies()[0]);
  EXPECT_EQ(tangle.pairs()[0].steps, 1U);
  EXPECT_GT(tangle.pairs()[0].curve_length, 1);
}

/// The mesh follows the cloth that moves out of it.
TEST_P(UntanglingMeshes, that_are_kinematic_keep_their_motion) {
  Tangle tangle("cloth-in-mesh", GetParam(), untangling(Detection::ccd));
  btRigidBody& mesh = *tangle.rigid_bodies()[0];
  mesh.setCollisionFlags(mesh.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  mesh.setActivationState(DISABLE_DEACTIVATION);
  btTransform place = btTransform::getIdentity();
  int steps = 0;
  for (; steps < kMostSteps && (steps < 2 || !tangle.pairs().empty()); ++steps) {
    place.getOrigin() += btVector3(0, btScalar(-0.3) * tangle.simulation().step_length(), 0);
    mesh.setWorldTransform(place);
    tangle.simulation().step_once();
  }
  EXPECT_LT(steps, kMostSteps);
  EXPECT_EQ(tangle.edges(), 0U);
  EXPECT_EQ(mesh.getWorldTransform().getOrigin(), place.getOrigin());
}

constexpr btScalar kLargeRadius = btScalar(1.5);

/// Most of the cloth is inside a mesh that is larger than it. The part of the mesh near the cloth is open, and the
/// smaller part of the cloth is outside.
TEST_P(UntanglingMeshes, that_are_large_have_an_inside) {
  const demo::IntersectingBodies bodies = {
      "", "",
      [](btSoftBodyWorldInfo& info, demo::World kind, int size) {
        auto made = demo::find_intersecting_bodies("cloth-in-mesh").make(info, kind, size);
        for (int n = 0; n < made[0]->m_nodes.size(); ++n) {
          made[0]->m_nodes[n].m_x += btVector3(kLargeRadius - btScalar(0.3), 0, 0);
          made[0]->m_nodes[n].m_q = made[0]->m_nodes[n].m_x;
        }
        return made;
      },
      [] {
        return std::vector<demo::MeshBody>{{demo::sphere_mesh(btVector3(0, 0, 0), kLargeRadius, 4), 0}};
      }};
  Tangle tangle(bodies, GetParam(), untangling(Detection::dcd));
  EXPECT_LT(tangle.steps_until_clean(), kMostSteps);
  const btSoftBody& cloth = *tangle.simulation().bodies()[0];
  for (int n = 0; n < cloth.m_nodes.size(); ++n) {
    ASSERT_GT(cloth.m_nodes[n].m_x.length(), btScalar(0.98) * kLargeRadius) << "node " << n;
  }
}

/// Impulses on the mesh and the cloth are equal and opposite. The cloth's damping takes momentum as well.
TEST_P(UntanglingMeshes, that_are_free_keep_the_common_momentum) {
  Tangle tangle("cloth-in-free-mesh", GetParam(), untangling(Detection::dcd));
  for (int i = 0; i < 4; ++i) {
    tangle.simulation().step_once();
    EXPECT_LT(tangle.drift(), 5e-4);
  }
  EXPECT_GT(tangle.rigid_bodies()[0]->getLinearVelocity().length(), 0.005);
}

INSTANTIATE_TEST_SUITE_P(InBothKinds, UntanglingMeshes, testing::Values(World::one_line, World::deformable),
                         world_name);

}  // namespace
}  // namespace softcd::test
