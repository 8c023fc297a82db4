// Soft bodies on rigid triangle meshes, in both worlds.

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <tuple>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h"
#include "BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "any_simulation.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::test {
namespace {

constexpr btScalar kHill = btScalar(0.15);
constexpr int kCells = 16;
constexpr btScalar kSide = 2;

/// The ground's height over the square from -1 to 1: hills that are flat at the border.
btScalar ground(btScalar x, btScalar z) {
  return kHill * (btCos(SIMD_PI * x) + 1) * (btCos(SIMD_PI * z) + 1) / 4;
}

/// A rigid shape with its parts.
struct MadeGround {
  std::unique_ptr<btTriangleMesh> triangles;
  std::unique_ptr<btBvhTriangleMeshShape> unscaled;
  std::vector<btScalar> heights;
  std::unique_ptr<btCollisionShape> part;
  std::unique_ptr<btCollisionShape> shape;
  btVector3 center{0, 0, 0};  ///< of the shape
};

std::unique_ptr<btTriangleMesh> ground_mesh(btScalar scale) {
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto point = [&](int i, int j) {
    const btScalar x = kSide * (btScalar(i) / kCells - btScalar(0.5));
    const btScalar z = kSide * (btScalar(j) / kCells - btScalar(0.5));
    return btVector3(x, ground(x, z), z) / scale;
  };
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      mesh->addTriangle(point(i, j), point(i, j + 1), point(i + 1, j));
      mesh->addTriangle(point(i + 1, j), point(i, j + 1), point(i + 1, j + 1));
    }
  }
  return mesh;
}

enum class Kind { bvh, scaled, gimpact, terrain, compound };

MadeGround make_ground(Kind kind) {
  MadeGround result;
  if (kind == Kind::terrain) {
    for (int j = 0; j <= kCells; ++j) {
      for (int i = 0; i <= kCells; ++i) {
        result.heights.push_back(
            ground(kSide * (btScalar(i) / kCells - btScalar(0.5)), kSide * (btScalar(j) / kCells - btScalar(0.5))));
      }
    }
    auto terrain = std::make_unique<btHeightfieldTerrainShape>(kCells + 1, kCells + 1, result.heights.data(),
                                                               btScalar(1), btScalar(0), kHill, 1,
                                                               sizeof(btScalar) == 8 ? PHY_DOUBLE : PHY_FLOAT, false);
    terrain->setLocalScaling(btVector3(kSide / kCells, 1, kSide / kCells));
    result.center.setY(kHill / 2);
    result.shape = std::move(terrain);
    return result;
  }
  const btScalar scale = kind == Kind::scaled ? btScalar(4) : btScalar(1);
  result.triangles = ground_mesh(scale);
  if (kind == Kind::gimpact) {
    auto gimpact = std::make_unique<btGImpactMeshShape>(result.triangles.get());
    gimpact->updateBound();
    result.shape = std::move(gimpact);
    return result;
  }
  auto mesh = std::make_unique<btBvhTriangleMeshShape>(result.triangles.get(), /*quantised=*/true);
  if (kind == Kind::scaled) {
    result.unscaled = std::move(mesh);
    result.shape =
        std::make_unique<btScaledBvhTriangleMeshShape>(result.unscaled.get(), btVector3(scale, scale, scale));
  } else if (kind == Kind::compound) {
    auto compound = std::make_unique<btCompoundShape>();
    btTransform offset = btTransform::getIdentity();
    offset.setOrigin(btVector3(0, 3, 0));
    compound->addChildShape(offset, mesh.get());
    result.center.setY(-3);
    result.part = std::move(mesh);
    result.shape = std::move(compound);
  } else {
    result.shape = std::move(mesh);
  }
  return result;
}

std::unique_ptr<btSoftBody> make_draped_sheet(btSoftBodyWorldInfo& info, btScalar height) {
  SheetOptions options;
  options.nodes_per_side = 13;
  options.height = height;
  options.margin = btScalar(0.03);
  auto sheet = make_sheet(info, options);
  sheet->m_cfg.kDF = btScalar(0.8);
  return sheet;
}

struct Gaps {
  btScalar lowest = btScalar(1e9), mean = 0;
  int under = 0;
};

Gaps gaps_above(const btSoftBody& body, btScalar ground_height = 0) {
  Gaps gaps;
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btVector3& x = body.m_nodes[n].m_x;
    const btScalar gap = x.y() - ground(x.x(), x.z()) - ground_height;
    gaps.lowest = btMin(gaps.lowest, gap);
    gaps.mean += gap / btScalar(body.m_nodes.size());
    gaps.under += gap < 0;
  }
  return gaps;
}

Gaps drape(World world, Kind kind, const std::optional<bullet::Settings>& settings, int steps) {
  MadeGround made = make_ground(kind);
  AnySimulation simulation(world, settings);
  if (kind == Kind::gimpact) {
    btGImpactCollisionAlgorithm::registerAlgorithm(
        static_cast<btCollisionDispatcher*>(simulation.world().getDispatcher()));
  }
  simulation.add_rigid(std::move(made.shape), made.center);
  btSoftBody& sheet = simulation.add(make_draped_sheet(simulation.world_info(), btScalar(0.35)));
  for (int step = 0; step < steps; ++step) simulation.step();
  return gaps_above(sheet);
}

std::string name_of_kind(Kind kind) {
  constexpr std::array kNames = {"bvh", "scaled", "gimpact", "terrain", "compound"};
  return kNames[static_cast<std::size_t>(kind)];
}

const auto kKinds = testing::Values(Kind::bvh, Kind::scaled, Kind::gimpact, Kind::terrain, Kind::compound);

class RigidMeshes : public testing::TestWithParam<std::tuple<World, Kind>> {};
INSTANTIATE_TEST_SUITE_P(Grounds, RigidMeshes, testing::Combine(kWorldsOfRun, kKinds), [](const auto& parameter) {
  return name_of(std::get<0>(parameter.param)) + "_" + name_of_kind(std::get<1>(parameter.param));
});

TEST_P(RigidMeshes, carry_a_cloth_at_the_margin) {
  const auto [world, kind] = GetParam();
  const Gaps gaps = drape(world, kind, test_settings(), 120);
  EXPECT_EQ(gaps.under, 0);
  EXPECT_NEAR(gaps.mean, 0.03, 0.001);
  EXPECT_NEAR(gaps.lowest, 0.03, 0.005);
}

TEST_P(RigidMeshes, are_bullets_again_when_asked) {
  const auto [world, kind] = GetParam();
  bullet::Settings settings = test_settings();
  settings.rigid_meshes = false;
  constexpr int kSteps = 60;
  const Gaps ours = drape(world, kind, settings, kSteps);
  const Gaps bullets = drape(world, kind, std::nullopt, kSteps);
  EXPECT_NEAR(ours.mean, bullets.mean, 0.01);
  EXPECT_GT(std::abs(ours.mean - btScalar(0.03)), 0.03) << "as with softcd";
}

class RigidMeshWorlds : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, RigidMeshWorlds, kWorldsOfRun, world_name);

TEST_P(RigidMeshWorlds, nothing_passes_through_a_thin_ground_at_60_metres_per_second) {
  MadeGround made = make_ground(Kind::bvh);
  AnySimulation simulation(GetParam(), test_settings());
  simulation.add_rigid(std::move(made.shape), made.center);
  btSoftBody& sheet = simulation.add(make_draped_sheet(simulation.world_info(), btScalar(0.6)));
  sheet.setVelocity(btVector3(0, -60, 0));
  for (int step = 0; step < 20; ++step) {
    simulation.step();
    if (step < 4) {
      EXPECT_EQ(gaps_above(sheet).under, 0) << "step " << step;
    }
  }
}

TEST_P(RigidMeshWorlds, a_rising_ground_lifts_the_cloth) {
  MadeGround made = make_ground(Kind::bvh);
  AnySimulation simulation(GetParam(), test_settings());
  btRigidBody& rigid = simulation.add_rigid(std::move(made.shape), made.center);
  rigid.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  rigid.setActivationState(DISABLE_DEACTIVATION);
  btSoftBody& sheet = simulation.add(make_draped_sheet(simulation.world_info(), btScalar(0.3)));
  btScalar height = 0;
  for (int step = 0; step < 120; ++step) {
    simulation.step([&](btScalar seconds) {
      if (step >= 60) height += seconds * btScalar(1.2);
      btTransform pose = btTransform::getIdentity();
      pose.setOrigin(btVector3(0, height, 0));
      rigid.setWorldTransform(pose);
    });
  }
  const Gaps gaps = gaps_above(sheet, height);
  EXPECT_EQ(gaps.under, 0);
  EXPECT_LT(gaps.mean, 0.1);
}

/// A tetrahedron of two kilograms falls on a sheet that is held along its border.
TEST_P(RigidMeshWorlds, a_falling_mesh_is_caught_by_a_cloth) {
  auto triangles = std::make_unique<btTriangleMesh>();
  const std::array<btVector3, 4> corners = {btVector3(btScalar(0.2), 0, 0), btVector3(btScalar(-0.1), 0, btScalar(0.2)),
                                            btVector3(btScalar(-0.1), 0, btScalar(-0.2)),
                                            btVector3(0, btScalar(0.3), 0)};
  triangles->addTriangle(corners[0], corners[2], corners[1]);
  triangles->addTriangle(corners[0], corners[1], corners[3]);
  triangles->addTriangle(corners[1], corners[2], corners[3]);
  triangles->addTriangle(corners[2], corners[0], corners[3]);
  auto shape = std::make_unique<btGImpactMeshShape>(triangles.get());
  shape->updateBound();
  AnySimulation simulation(GetParam(), test_settings());
  auto sheet = make_draped_sheet(simulation.world_info(), 0);
  for (int n = 0; n < sheet->m_nodes.size(); ++n) {
    const btVector3& x = sheet->m_nodes[n].m_x;
    if (btMax(btFabs(x.x()), btFabs(x.z())) > btScalar(0.49)) sheet->setMass(n, 0);
  }
  btSoftBody& held = simulation.add(std::move(sheet));
  btRigidBody& mesh = simulation.add_rigid(std::move(shape), btVector3(0, btScalar(0.15), 0), btScalar(0.2));
  int contacts = 0;
  for (int step = 0; step < 40; ++step) {
    simulation.step();
    contacts += AnySimulation::count_contacts(held);
  }
  EXPECT_GT(contacts, 10);
  const btScalar free_fall = btScalar(0.15) - btScalar(5) * (40 * kStep) * (40 * kStep);
  EXPECT_GT(mesh.getWorldTransform().getOrigin().y(), free_fall + 1) << "the cloth did not hold it";
}

TEST_P(RigidMeshWorlds, ignored_pairs_and_masks_are_respected) {
  for (const bool by_mask : {false, true}) {
    MadeGround made = make_ground(Kind::bvh);
    AnySimulation simulation(GetParam(), test_settings());
    btRigidBody& rigid = simulation.add_rigid(std::move(made.shape), made.center);
    if (by_mask) rigid.getBroadphaseProxy()->m_collisionFilterMask = 0;
    btSoftBody& sheet = simulation.add(make_draped_sheet(simulation.world_info(), btScalar(0.2)));
    sheet.setIgnoreCollisionCheck(&rigid, !by_mask);
    rigid.setIgnoreCollisionCheck(&sheet, !by_mask);
    for (int step = 0; step < 60; ++step) simulation.step();
    EXPECT_LT(mean_height(sheet), -1) << "by mask: " << by_mask;
  }
}

TEST_P(RigidMeshWorlds, a_mesh_that_changes_or_goes_is_noticed) {
  MadeGround high = make_ground(Kind::bvh);
  AnySimulation simulation(GetParam(), test_settings());
  btRigidBody& rigid = simulation.add_rigid(std::move(high.shape), btVector3(0, 0, 0));
  btSoftBody& sheet = simulation.add(make_draped_sheet(simulation.world_info(), btScalar(0.2)));
  for (int step = 0; step < 60; ++step) simulation.step();
  EXPECT_EQ(gaps_above(sheet).under, 0);
  rigid.getCollisionShape()->setLocalScaling(btVector3(1, btScalar(0.01), 1));
  simulation.world().updateSingleAabb(&rigid);
  for (int step = 0; step < 120; ++step) simulation.step();
  EXPECT_NEAR(mean_height(sheet), 0.03, 0.02);
}

/// A thin spike under the middle of a sheet of eight large faces, away from all nodes.
btScalar fall_on_spike(int flags) {
  btTriangleMesh triangles;
  const std::array<btVector3, 4> corners = {
      btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.2)), btVector3(btScalar(0.31), -1, btScalar(0.2)),
      btVector3(btScalar(0.29), -1, btScalar(0.21)), btVector3(btScalar(0.29), -1, btScalar(0.19))};
  for (std::size_t i = 0; i < 3; ++i) triangles.addTriangle(corners[0], corners[1 + i], corners[1 + (i + 1) % 3]);
  demo::DeformableSimulation simulation(test_settings());
  simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles, true), btVector3(0, 0, 0));
  SheetOptions options;
  options.nodes_per_side = 3;
  options.side = 2;
  options.height = btScalar(0.3);
  options.margin = btScalar(0.03);
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  sheet.m_cfg.collisions |= flags;
  for (int step = 0; step < 90; ++step) simulation.step(kStep / 4);
  return height_at(sheet, corners[0].x(), corners[0].z()).value_or(0);
}

TEST(RigidMeshes, hold_faces_of_deformable_bodies_between_their_nodes) {
  for (const int flag : {0, int(btSoftBody::fCollision::SDF_RDF)}) {
    EXPECT_GT(fall_on_spike(flag), btScalar(0.19)) << "the spike is 0.2 high";
  }
}

class ClassicRigidMeshes : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ClassicRigidMeshes,
                         worlds_of_run({World::one_line, World::multi_body, World::attached}), world_name);

// In a step the pressure moves nodes by more than the ball's radius. Contacts that stop such nodes where they are, far
// from the walls, let the ball shrink until it turns inside out.
TEST_P(ClassicRigidMeshes, let_a_ball_under_pressure_fill_the_space_between_them) {
  constexpr btScalar kWallX = btScalar(0.3);
  btTriangleMesh walls;
  for (const btScalar x : {-kWallX, kWallX}) {
    walls.addTriangle(btVector3(x, -1, -1), btVector3(x, 1, -1), btVector3(x, -1, 1));
    walls.addTriangle(btVector3(x, 1, -1), btVector3(x, 1, 1), btVector3(x, -1, 1));
  }
  for (const int iterations : {1, 4}) {
    AnySimulation simulation(GetParam(), test_settings());
    simulation.set_gravity(btVector3(0, 0, 0));
    auto shape = std::make_unique<btBvhTriangleMeshShape>(&walls, /*quantised=*/true);
    shape->setMargin(btScalar(0.02));
    simulation.add_rigid(std::move(shape), btVector3(0, 0, 0));
    auto made = demo::make_body(simulation.world_info(), demo::sphere_mesh(btVector3(0, 0, 0), btScalar(0.25), 2), 1);
    made->setTotalMass(1);
    made->getCollisionShape()->setMargin(btScalar(0.02));
    made->m_cfg.kPR = 100;
    made->m_cfg.kDP = btScalar(0.01);
    made->m_cfg.piterations = iterations;
    made->m_cfg.collisions |= btSoftBody::fCollision::SDF_RS;
    const btSoftBody& ball = simulation.add(std::move(made));
    const btScalar volume_at_rest = ball.getVolume();
    for (int step = 0; step < 20; ++step) {
      simulation.step();
      if (step < 5) continue;  // Bullet pushes by the normals and the volume of the step before
      ASSERT_GT(ball.getVolume(), volume_at_rest) << iterations << " iterations, step " << step;
    }
    btScalar left = 0, right = 0;
    for (int n = 0; n < ball.m_nodes.size(); ++n) {
      left = btMin(left, ball.m_nodes[n].m_x.x());
      right = btMax(right, ball.m_nodes[n].m_x.x());
    }
    EXPECT_NEAR(left, -kWallX + btScalar(0.04), 0.01) << iterations;
    EXPECT_NEAR(right, kWallX - btScalar(0.04), 0.01) << iterations;
  }
}

// Bullet's default of one iteration: its links pull nodes through the ground after their contacts were solved.
TEST(RigidMeshes, carry_a_cloth_over_steep_waves_with_one_iteration) {
  const auto height_of = [](btScalar x, btScalar z) { return btScalar(0.15) * btSin(5 * x) * btCos(4 * z); };
  btTriangleMesh waves;
  const auto point = [&](int i, int j) {
    const btScalar x = btScalar(i) / 8 - 2, z = btScalar(j) / 8 - 2;
    return btVector3(x, height_of(x, z), z);
  };
  for (int i = 0; i < 32; ++i) {
    for (int j = 0; j < 32; ++j) {
      waves.addTriangle(point(i, j), point(i, j + 1), point(i + 1, j));
      waves.addTriangle(point(i + 1, j), point(i, j + 1), point(i + 1, j + 1));
    }
  }
  for (const World world : {World::one_line, World::multi_body, World::attached}) {
    AnySimulation simulation(world, test_settings());
    simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&waves, /*quantised=*/true), btVector3(0, 0, 0));
    auto patch = std::unique_ptr<btSoftBody>(btSoftBodyHelpers::CreatePatch(
        simulation.world_info(), btVector3(-1, btScalar(0.5), -1), btVector3(1, btScalar(0.5), -1),
        btVector3(-1, btScalar(0.5), 1), btVector3(1, btScalar(0.5), 1), 25, 25, 0, true));
    patch->getCollisionShape()->setMargin(btScalar(0.05));
    const btSoftBody& cloth = simulation.add(std::move(patch));
    for (int step = 0; step < 150; ++step) simulation.step();
    int below = 0;
    for (int n = 0; n < cloth.m_nodes.size(); ++n) {
      const btVector3& x = cloth.m_nodes[n].m_x;
      below += x.y() < height_of(x.x(), x.z()) - btScalar(0.03) ? 1 : 0;
    }
    EXPECT_EQ(below, 0) << name_of(world);
  }
}

}  // namespace
}  // namespace softcd::test
