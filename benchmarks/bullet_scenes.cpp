#include "bullet_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "scenes/cloth.hpp"
#include "scenes/soft_ball.hpp"
#include "scenes/two_cloths.hpp"

namespace softcd::benchmarks {
namespace {

constexpr btScalar kCell = btScalar(0.1);  // of the cloths on a floor
constexpr btScalar kClothMargin = kCell / 4;
constexpr btScalar kNodeMass = btScalar(0.01);

constexpr btScalar kHumpRadius = btScalar(0.35);
constexpr btScalar kHumpPitch = btScalar(1.5);

// A sine-generated curve: its direction swings to and fro by this angle. It is a little more than a right angle, so
// that each fold hangs over the one below.
constexpr btScalar kFoldAngle = 2;
constexpr int kCellsPerFold = 24;
constexpr btScalar kTilt = btScalar(0.06);  // radians; no two folds meet all at once

constexpr btScalar kBallRadius = btScalar(0.5);
constexpr btScalar kBallMargin = btScalar(0.01);  // a sixth of an edge
constexpr btScalar kBallSpacing = btScalar(1.02);
constexpr btScalar kLayerHeight = btScalar(0.9);  // each layer lies in the gaps of the one below
constexpr btScalar kInwards = btScalar(0.1);      // velocity over distance from the middle

void add_floor(SoftWorld& world, btScalar half_side) {
  world.add_rigid(std::make_unique<btBoxShape>(btVector3(half_side, 1, half_side)), btVector3(0, -1, 0));
}

std::unique_ptr<btSoftBody> make_configured_cloth(SoftWorld& world, const demo::ClothShape& shape) {
  auto cloth = demo::make_cloth(world.world_info(), shape, kNodeMass * btScalar(shape.columns * shape.rows));
  cloth->getCollisionShape()->setMargin(kClothMargin);
  cloth->m_cfg.kKHR = 1;  // nothing sinks into what is static
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  cloth->m_cfg.piterations = 4;
  return cloth;
}

void fill_two_cloths(SoftWorld& world, int nodes_per_side) {
  demo::LowerAndUpperCloth cloths = demo::make_two_cloths(world.world_info(), nodes_per_side);
  world.add(std::move(cloths.lower));
  world.add(std::move(cloths.upper));
}

void fill_draped(SoftWorld& world, int nodes_per_side) {
  const btScalar side = kCell * btScalar(nodes_per_side - 1);
  add_floor(world, side);
  const int humps = std::max(1, static_cast<int>(side / kHumpPitch));
  const auto offset = [=](int hump) { return kHumpPitch * (btScalar(hump) - btScalar(humps - 1) / 2); };
  for (int x = 0; x < humps; ++x) {
    for (int z = 0; z < humps; ++z) {
      world.add_rigid(std::make_unique<btSphereShape>(kHumpRadius), btVector3(offset(x), kHumpRadius, offset(z)));
    }
  }
  const btScalar height = 2 * kHumpRadius + 3 * kClothMargin;
  auto cloth = make_configured_cloth(world, demo::horizontal_cloth(nodes_per_side, side, height));
  // The classic world's own detection finds no contacts within a body, and this cloth has few.
  cloth->setSelfCollision(world.kind() == World::deformable);
  world.add(std::move(cloth));
}

std::vector<btVector3> folded_curve(int nodes) {
  std::vector<btVector3> curve = {btVector3(0, 0, 0)};
  for (int i = 1; i < nodes; ++i) {
    const btScalar angle = kFoldAngle * btSin(SIMD_2_PI * (btScalar(i) - btScalar(0.5)) / btScalar(kCellsPerFold));
    curve.push_back(curve.back() + kCell * btVector3(0, btCos(angle), btSin(angle)));
  }
  return curve;
}

void fill_crumpling(SoftWorld& world, int nodes_per_side) {
  const btScalar side = kCell * btScalar(nodes_per_side - 1);
  add_floor(world, side);
  demo::ClothShape shape;
  shape.columns = nodes_per_side;
  shape.rows = nodes_per_side;
  shape.position = [=, curve = folded_curve(nodes_per_side)](int column, int row) {
    return curve[static_cast<std::size_t>(row)] + btVector3(kCell * btScalar(column) - side / 2, 0, 0);
  };
  auto cloth = make_configured_cloth(world, shape);
  cloth->rotate(btQuaternion(btVector3(1, 0, 1).normalized(), kTilt));
  btVector3 low, high;
  cloth->getAabb(low, high);
  cloth->translate(btVector3(0, 3 * kClothMargin - low.y(), 0));
  cloth->setSelfCollision(true);
  world.add(std::move(cloth));
}

void fill_stacked(SoftWorld& world, int nodes_per_side) {
  const btScalar side = kCell * btScalar(nodes_per_side - 1);
  add_floor(world, side);
  for (const int layer : {1, 2}) {
    const btScalar height = 3 * kClothMargin * btScalar(layer);
    auto cloth = make_configured_cloth(world, demo::horizontal_cloth(nodes_per_side, side, height));
    cloth->setSelfCollision(true);
    world.add(std::move(cloth));
  }
}

void fill_balls(SoftWorld& world, int count) {
  add_floor(world, 20);
  const int per_side = std::max(1, static_cast<int>(std::lround(std::cbrt(1.25 * count))));
  for (int ball = 0; ball < count; ++ball) {
    const int layer = ball / (per_side * per_side);
    const btScalar offset = kBallSpacing * (btScalar(layer % 2) / 2 - btScalar(per_side - 1) / 2);
    const btVector3 center(offset + kBallSpacing * btScalar(ball % per_side),
                           kBallRadius + 2 * kBallMargin + kLayerHeight * btScalar(layer),
                           offset + kBallSpacing * btScalar(ball / per_side % per_side));
    auto body = demo::make_soft_ball(world, {center, kBallRadius, 3, 1, kBallMargin});
    body->setVelocity(btVector3(-kInwards * center.x(), 0, -kInwards * center.z()));
    world.add(std::move(body));
  }
}

}  // namespace

void fill(SoftWorld& world, BulletScene scene, int size) {
  switch (scene) {
    case BulletScene::two_cloths:
      return fill_two_cloths(world, size);
    case BulletScene::balls:
      return fill_balls(world, size);
    case BulletScene::draped:
      return fill_draped(world, size);
    case BulletScene::crumpling:
      return fill_crumpling(world, size);
    case BulletScene::stacked:
      return fill_stacked(world, size);
  }
}

int default_warm_up(BulletScene scene, World world) {
  const bool is_classic = world == World::classic;
  switch (scene) {
    case BulletScene::two_cloths:
      return is_classic ? 90 : 150;
    case BulletScene::balls:
      return is_classic ? 20 : 80;
    case BulletScene::draped:
    case BulletScene::crumpling:
    case BulletScene::stacked:
      return is_classic ? 60 : 120;
  }
  return 0;
}

}  // namespace softcd::benchmarks
