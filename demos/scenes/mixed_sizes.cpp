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

constexpr btScalar kLowerRadius = 3;
constexpr btScalar kUpperRadius = btScalar(1.7);  // nothing hangs over the border of the lower one
constexpr btScalar kLowerHeight = btScalar(2.2);
constexpr btScalar kMixedSizesDrop = btScalar(0.3);
const btVector3 kUpperOffset(1, kMixedSizesDrop, btScalar(0.5));
constexpr btScalar kMarginInEdges = btScalar(0.25);  // of the shortest

/// Makes a cloth of similar triangles, from a fan in the middle outwards.
std::unique_ptr<btSoftBody> make_graded_cloth(btSoftBodyWorldInfo& world_info, int segments, btScalar outer_radius) {
  const btScalar growth = 1 + SIMD_2_PI / btScalar(segments);
  std::vector<ProfilePoint> profile;
  for (btScalar radius = outer_radius; radius > outer_radius / kEdgeRatio; radius /= growth) {
    profile.push_back({radius, kLowerHeight});
  }
  profile.push_back({0, kLowerHeight});
  auto cloth = make_body(world_info, lathe_mesh(profile, segments), 1);
  cloth->setTotalMass(2, /*fromfaces=*/true);
  cloth->getCollisionShape()->setMargin(kMarginInEdges * (growth - 1) * outer_radius / kEdgeRatio);
  cloth->setSelfCollision(true);
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.02);
  cloth->m_cfg.piterations = 8;
  return cloth;
}

constexpr btScalar kMixedSizesBallRadius = btScalar(0.095);
constexpr int kMixedSizesBallSubdivisions = 3;
constexpr btScalar kBallMargin = btScalar(0.003);  // a quarter of an edge
// The balls fall onto a disc, along the spiral of a sunflower's seeds.
constexpr btScalar kRainRadius = btScalar(1.9);
constexpr btScalar kGoldenAngle = btScalar(2.39996);
constexpr btScalar kHeightBetween = btScalar(0.15);

// The boulders lie around a pit, half in the floor; neighbours do not touch.
constexpr int kBoulderCount = 5;
constexpr btScalar kBoulderRadius = btScalar(1.2);
constexpr btScalar kBoulderHeight = btScalar(0.4);
constexpr btScalar kPitRadius = btScalar(2.1);  // to the boulders' centres

}  // namespace

MixedSizesCloth::MixedSizesCloth(const SceneOptions& options) : Scene(options) {
  auto lower = make_graded_cloth(simulation().world_info(), options.size, kLowerRadius);
  for (int i = 0; i < options.size; ++i) lower->setMass(i, 0);  // the outermost ring
  lower_ = &add(std::move(lower));
  auto upper = make_graded_cloth(simulation().world_info(), options.size, kUpperRadius);
  upper->translate(kUpperOffset);
  upper_ = &add(std::move(upper));
}

void MixedSizesCloth::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body == upper_) mark_below(*lower_, body, marked);
}

std::vector<Surface> MixedSizesCloth::surfaces() const {
  return {{lower_, {0.10F, 0.28F, 0.42F}, {0.35F, 0.42F, 0.45F}, true},
          {upper_, {0.60F, 0.30F, 0.05F}, {0.5F, 0.1F, 0.1F}, true}};
}

View MixedSizesCloth::view() const {
  return {btVector3(btScalar(4.4), btScalar(5.6), btScalar(6.4)), btVector3(0, btScalar(1.8), 0)};
}

MixedSizesBalls::MixedSizesBalls(const SceneOptions& options) : Scene(options) {
  simulation().add_rigid(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  for (int i = 0; i < kBoulderCount; ++i) {
    const btScalar angle = SIMD_2_PI * btScalar(i) / btScalar(kBoulderCount);
    const btVector3 center(kPitRadius * btCos(angle), kBoulderHeight, kPitRadius * btSin(angle));
    auto boulder = make_ball(simulation().world_info(), center, kBoulderRadius, 0);
    boulder->getCollisionShape()->setMargin(kBallMargin);
    boulder->m_cfg.kDF = btScalar(0.1);
    boulders_.push_back(&add(std::move(boulder)));
  }
  const btScalar bottom = kBoulderHeight + kBoulderRadius + 2 * kMixedSizesBallRadius;
  for (int ball = 0; ball < options.size; ++ball) {
    const btScalar radius = kRainRadius * btSqrt((btScalar(ball) + btScalar(0.5)) / btScalar(options.size));
    const btScalar angle = kGoldenAngle * btScalar(ball);
    const btVector3 center(radius * btCos(angle), bottom + kHeightBetween * btScalar(ball), radius * btSin(angle));
    auto soft =
        make_soft_ball(simulation(), {center, kMixedSizesBallRadius, kMixedSizesBallSubdivisions, 1, kBallMargin});
    soft->setSelfCollision(true);
    balls_.push_back(&add(std::move(soft)));
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
  for (const btSoftBody* boulder : boulders_)
    surfaces.push_back({boulder, {0.35F, 0.33F, 0.30F}, {0.1F, 0.1F, 0.1F}, true});
  for (const btSoftBody* ball : balls_) surfaces.push_back({ball, {0.70F, 0.30F, 0.04F}, {0.1F, 0.1F, 0.1F}, true});
  return surfaces;
}

View MixedSizesBalls::view() const {
  return {btVector3(btScalar(1.8), btScalar(8.9), btScalar(7.9)), btVector3(0, btScalar(0.2), 0)};
}

}  // namespace softcd::demo
