#include "scenes/n_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "scenes/penetration.hpp"
#include "scenes/soft_ball.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kNBodyBallRadius = btScalar(0.25);
constexpr int kNBodyBallSubdivisions = 2;
constexpr btScalar kMargin = btScalar(0.01);  // an eighth of a ball's edges
constexpr btScalar kSpacing = btScalar(2.3) * kNBodyBallRadius;
constexpr btScalar kConeRadius = btScalar(0.9);
constexpr btScalar kConeHeight = btScalar(1.6);
constexpr int kConeSegments = 24;
constexpr btScalar kUsualTop = 4;
constexpr btScalar kFirstLayer = kConeHeight + 2 * kNBodyBallRadius;

// Cones around a middle one; they do not touch.
const std::array<btVector3, 7> kConePlaces = {{{0, 0, 0},
                                               {2, 0, 0},
                                               {1, 0, btScalar(1.73)},
                                               {-1, 0, btScalar(1.73)},
                                               {-2, 0, 0},
                                               {-1, 0, btScalar(-1.73)},
                                               {1, 0, btScalar(-1.73)}}};

constexpr std::array<Color, 4> kBallColors = {
    {{0.62F, 0.10F, 0.07F}, {0.75F, 0.42F, 0.06F}, {0.08F, 0.30F, 0.50F}, {0.16F, 0.40F, 0.18F}}};

}  // namespace

NBody::NBody(const SceneOptions& options) : Scene(options) {
  simulation().add_rigid(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  add_cones();
  add_balls(options.size);
}

void NBody::add_cones() {
  // Above the floor by a margin, so that rounding cannot make them touch.
  const btScalar base = kMargin;
  const SurfaceMesh mesh = lathe_mesh({{0, base}, {kConeRadius, base}, {0, base + kConeHeight}}, kConeSegments);
  for (const btVector3& place : kConePlaces) {
    auto cone = make_body(simulation().world_info(), mesh, 0);
    cone->translate(place);
    cone->getCollisionShape()->setMargin(kMargin);
    cone->m_cfg.kDF = btScalar(0.2);
    cones_.push_back(&add(std::move(cone)));
  }
}

void NBody::add_balls(int count) {
  // Layers as wide as the ring of cones; each layer lies in the gaps of the one below.
  const int per_side = std::clamp(static_cast<int>(std::lround(std::cbrt(3 * count))), 2, 8);
  for (int ball = 0; ball < count; ++ball) {
    const int layer = ball / (per_side * per_side);
    const btScalar offset = kSpacing * (btScalar(layer % 2) / 2 - btScalar(per_side) / 2 + btScalar(0.25));
    const btVector3 center(offset + kSpacing * btScalar(ball % per_side), kFirstLayer + kSpacing * btScalar(layer),
                           offset + kSpacing * btScalar(ball / per_side % per_side));
    auto soft = make_soft_ball(simulation(), {center, kNBodyBallRadius, kNBodyBallSubdivisions, 1, kMargin});
    // Matching the shape keeps the balls from being crushed.
    soft->setSelfCollision(true);
    balls_.push_back(&add(std::move(soft)));
    top_ = center.y() + kNBodyBallRadius;
  }
}

void NBody::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  for (const btSoftBody* cone : cones_) {
    if (cone != &body) mark_inside(*cone, body, marked);
  }
  for (const btSoftBody* ball : balls_) {
    if (ball != &body) mark_inside(*ball, body, marked);
  }
}

std::vector<Surface> NBody::surfaces() const {
  std::vector<Surface> surfaces;
  for (const btSoftBody* cone : cones_) surfaces.push_back({cone, {0.35F, 0.33F, 0.30F}, {0.1F, 0.1F, 0.1F}});
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    surfaces.push_back({balls_[i], kBallColors[i % kBallColors.size()], {0.1F, 0.1F, 0.1F}});
  }
  return surfaces;
}

View NBody::view() const {
  const btScalar distance = btMax(btScalar(1), top_ / kUsualTop);
  return {distance * btVector3(btScalar(6.4), btScalar(5.7), btScalar(8.8)), distance * btVector3(0, btScalar(0.7), 0)};
}

}  // namespace softcd::demo
