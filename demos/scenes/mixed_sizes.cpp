#include "scenes/mixed_sizes.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"
#include "scenes/soft_ball.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kEdgeRatio = 100;

constexpr btScalar kClothRadius = 3;
constexpr btScalar kLowerHeight = btScalar(2.2);
constexpr btScalar kDrop = btScalar(0.3);
constexpr btScalar kUpperOffset = btScalar(1.2);
constexpr btScalar kClothMargin = btScalar(0.01);

/// Similar triangles, from a fan in the middle outwards.
std::unique_ptr<btSoftBody> make_graded_cloth(btSoftBodyWorldInfo& world_info, int segments, const btVector3& center) {
  const btScalar growth = 1 + SIMD_2_PI / btScalar(segments);
  std::vector<ProfilePoint> profile;
  for (btScalar radius = kClothRadius; radius > kClothRadius / kEdgeRatio; radius /= growth)
    profile.push_back({radius, 0});
  profile.push_back({0, 0});
  auto cloth = make_body(world_info, lathe_mesh(profile, segments), 1);
  cloth->setTotalMass(2, /*fromfaces=*/true);
  cloth->translate(center);
  cloth->getCollisionShape()->setMargin(kClothMargin);
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.02);
  cloth->m_cfg.piterations = 8;
  return cloth;
}

constexpr btScalar kBallRadius = btScalar(0.12);
constexpr int kBallSubdivisions = 3;
constexpr btScalar kBallMargin = btScalar(0.004);  // a quarter of an edge
constexpr btScalar kBallSpacing = btScalar(2.2) * kBallRadius;
constexpr int kBallsPerSide = 4;

struct Boulder {
  btVector3 center;
  btScalar radius;
};

// Icosahedra, half in the floor; stairs for the balls.
const std::array<Boulder, 3> kBoulders = {{{{0, btScalar(0.5), 0}, btScalar(1.5)},
                                           {{btScalar(1.9), 0, btScalar(1.6)}, btScalar(1.0)},
                                           {{btScalar(-1.8), 0, btScalar(1.8)}, btScalar(1.1)}}};

}  // namespace

MixedSizesCloth::MixedSizesCloth(const SceneOptions& options) : Scene(options) {
  auto lower = make_graded_cloth(simulation().world_info(), options.size, btVector3(0, kLowerHeight, 0));
  for (int i = 0; i < options.size; ++i) lower->setMass(i, 0);  // the outermost ring
  lower_ = &add(std::move(lower));
  upper_ = &add(make_graded_cloth(simulation().world_info(), options.size,
                                  btVector3(kUpperOffset, kLowerHeight + kDrop, kUpperOffset / 2)));
}

void MixedSizesCloth::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body == upper_) mark_below(*lower_, body, marked);
}

std::vector<Surface> MixedSizesCloth::surfaces() const {
  return {{lower_, {0.10F, 0.28F, 0.42F}, {0.35F, 0.42F, 0.45F}}, {upper_, {0.60F, 0.30F, 0.05F}, {0.5F, 0.1F, 0.1F}}};
}

View MixedSizesCloth::view() const {
  return {btVector3(btScalar(5.5), btScalar(6.5), btScalar(8)), btVector3(0, btScalar(1.7), 0)};
}

MixedSizesBalls::MixedSizesBalls(const SceneOptions& options) : Scene(options) {
  simulation().add_static(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  for (const auto& [center, radius] : kBoulders) {
    auto boulder = make_ball(simulation().world_info(), center, radius, 0);
    boulder->getCollisionShape()->setMargin(kBallMargin);
    boulder->m_cfg.kDF = btScalar(0.1);
    boulders_.push_back(&add(std::move(boulder)));
  }
  const btScalar bottom = kBoulders[0].center.y() + kBoulders[0].radius + 2 * kBallRadius;
  for (int ball = 0; ball < options.size; ++ball) {
    const int layer = ball / (kBallsPerSide * kBallsPerSide);
    const btScalar offset = (btScalar(layer % 2) - btScalar(kBallsPerSide)) / 2;
    const btVector3 center(kBallSpacing * (offset + btScalar(ball % kBallsPerSide)),
                           bottom + kBallSpacing * btScalar(layer),
                           kBallSpacing * (offset + btScalar(ball / kBallsPerSide % kBallsPerSide)));
    balls_.push_back(&add(make_soft_ball(simulation(), {center, kBallRadius, kBallSubdivisions, 1, kBallMargin})));
  }
}

void MixedSizesBalls::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  for (const btSoftBody* boulder : boulders_) {
    if (boulder != &body) mark_inside(*boulder, body, marked);
  }
  for (const btSoftBody* ball : balls_) {
    if (ball != &body) mark_inside(*ball, body, marked);
  }
}

std::vector<Surface> MixedSizesBalls::surfaces() const {
  std::vector<Surface> surfaces;
  for (const btSoftBody* boulder : boulders_) surfaces.push_back({boulder, {0.35F, 0.33F, 0.30F}, {0.1F, 0.1F, 0.1F}});
  for (const btSoftBody* ball : balls_) surfaces.push_back({ball, {0.70F, 0.30F, 0.04F}, {0.1F, 0.1F, 0.1F}});
  return surfaces;
}

View MixedSizesBalls::view() const {
  return {btVector3(btScalar(3.0), btScalar(4.2), btScalar(6.5)), btVector3(0, btScalar(1.2), 0)};
}

}  // namespace softcd::demo
