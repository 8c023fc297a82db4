#include "ball_heap.hpp"

#include "scenes/cloth.hpp"

namespace softcd::benchmarks {
namespace {

constexpr int kPerSide = 5;
constexpr int kLayers = 4;
constexpr btScalar kRadius = btScalar(0.5);
constexpr btScalar kMargin = btScalar(0.01);  // a sixth of an edge
constexpr btScalar kSpacing = btScalar(1.02);
constexpr btScalar kLayerHeight = btScalar(0.9);  // each layer lies in the gaps of the one below
constexpr btScalar kInwards = btScalar(0.1);      // velocity over distance from the middle

std::unique_ptr<btSoftBody> make_soft_ball(btSoftBodyWorldInfo& world_info, const btVector3& center) {
  auto ball = demo::make_ball(world_info, center, kRadius, 3);
  for (int i = 0; i < ball->m_nodes.size(); ++i) ball->setMass(i, 1);
  ball->setTotalMass(1);
  ball->setPose(/*bvolume=*/false, /*bframe=*/true);
  ball->m_cfg.kMT = btScalar(0.6);  // keeps it round
  ball->m_cfg.kDF = btScalar(0.5);
  ball->m_cfg.collisions |= btSoftBody::fCollision::SDF_RS;
  ball->getCollisionShape()->setMargin(kMargin);
  ball->setVelocity(btVector3(-kInwards * center.x(), 0, -kInwards * center.z()));
  return ball;
}

}  // namespace

BallHeap::BallHeap(const demo::SceneOptions& options) : Scene(options) {
  simulation().add_static_box(btVector3(20, 1, 20), btVector3(0, -1, 0));
  for (int layer = 0; layer < kLayers; ++layer) {
    const btScalar offset = kSpacing * (btScalar(layer % 2) / 2 - btScalar(kPerSide - 1) / 2);
    for (int i = 0; i < kPerSide * kPerSide; ++i) {
      const btVector3 center(offset + kSpacing * btScalar(i % kPerSide),
                             kRadius + 2 * kMargin + kLayerHeight * btScalar(layer),
                             offset + kSpacing * btScalar(i / kPerSide));
      balls_.push_back(&add(make_soft_ball(simulation().world_info(), center)));
    }
  }
}

std::vector<demo::Surface> BallHeap::surfaces() const {
  std::vector<demo::Surface> surfaces;
  for (const btSoftBody* ball : balls_) surfaces.push_back({ball, {0.6F, 0.3F, 0.05F}, {0.5F, 0.1F, 0.1F}});
  return surfaces;
}

demo::View BallHeap::view() const {
  return {btVector3(7, 5, 7), btVector3(0, 1, 0)};
}

void BallHeap::mark_passed_through(const btSoftBody& /*body*/, std::vector<bool>& /*marked*/) const {}

}  // namespace softcd::benchmarks
