#include "scenes/funnel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "scenes/cloth.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kFunnelSide = btScalar(3.2);
constexpr btScalar kSpoutRadius = btScalar(0.4);
constexpr btScalar kRimRadius = btScalar(2.4);
constexpr btScalar kSpoutBottom = btScalar(2.0);
constexpr btScalar kSpoutTop = btScalar(2.6);
constexpr btScalar kRimHeight = btScalar(3.8);
constexpr btScalar kStartHeight = kRimHeight + btScalar(0.1);

constexpr btScalar kPullRadius = btScalar(0.14);
constexpr btScalar kPulledMass = 30;  // times the other nodes'
// Small, because Bullet's solver applies friction in each of its iterations for each contact of a node.
constexpr btScalar kFunnelFriction = btScalar(0.002);
constexpr btScalar kPullFrom = btScalar(0.6);  // seconds
constexpr btScalar kPullSpeed = 1;
constexpr btScalar kReleaseHeight = btScalar(0.4);

// The cloth's folds fill the spout, so the margin must let all layers fit.
constexpr btScalar kLargestMargin = btScalar(0.012);

const std::vector<ProfilePoint> kProfile = {
    {kSpoutRadius, kSpoutBottom}, {kSpoutRadius, kSpoutTop}, {kRimRadius, kRimHeight}};

btScalar wall_radius(btScalar height) {
  if (height < kSpoutTop) return kSpoutRadius;
  return kSpoutRadius + (height - kSpoutTop) * (kRimRadius - kSpoutRadius) / (kRimHeight - kSpoutTop);
}

}  // namespace

Funnel::Funnel(const SceneOptions& options) : Scene(options) {
  simulation().add_rigid(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  const btScalar spacing = kFunnelSide / btScalar(options.size - 1);
  const btScalar margin = std::min(spacing / 4, kLargestMargin);

  auto cloth = make_cloth(simulation().world_info(), horizontal_cloth(options.size, kFunnelSide, kStartHeight), 1);
  cloth->getCollisionShape()->setMargin(margin);
  cloth->setSelfCollision(true);
  cloth->m_cfg.kDF = kFunnelFriction;
  cloth->m_cfg.kDP = btScalar(0.02);
  cloth->m_cfg.kKHR = 1;
  cloth->m_cfg.piterations = 12;
  for (int i = 0; i < cloth->m_nodes.size(); ++i) {
    const btVector3& x = cloth->m_nodes[i].m_x;
    if (std::hypot(x.x(), x.z()) > std::max(kPullRadius, spacing)) continue;
    cloth->setMass(i, kPulledMass * cloth->getMass(i));
    pulled_.push_back(i);
  }
  cloth_ = &add(std::move(cloth));

  const btScalar coarse = 2 * spacing;
  const int segments = std::max(24, static_cast<int>(SIMD_2_PI * kSpoutRadius / spacing));
  auto funnel = make_body(simulation().world_info(), lathe_mesh(refined(kProfile, coarse), segments), 0);
  funnel->getCollisionShape()->setMargin(margin);
  funnel->m_cfg.kDF = kFunnelFriction;
  funnel_ = &add(std::move(funnel));
}

// Sets velocities, not positions: where the cloth is stuck, the solver keeps the nodes back.
void Funnel::animate() {
  if (time() < kPullFrom) return;
  for (const int i : pulled_) {
    btSoftBody::Node& node = cloth_->m_nodes[i];
    if (node.m_x.y() > kReleaseHeight) node.m_v.setY(-kPullSpeed);
  }
}

void Funnel::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body != cloth_) return;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    if (x.y() > kSpoutBottom && x.y() < kRimHeight && std::hypot(x.x(), x.z()) > wall_radius(x.y())) {
      marked[static_cast<std::size_t>(i)] = true;
    }
  }
}

std::vector<Surface> Funnel::surfaces() const {
  return {{cloth_, {0.62F, 0.10F, 0.07F}, {0.78F, 0.50F, 0.14F}},
          {funnel_, {0.20F, 0.30F, 0.36F}, {0.42F, 0.48F, 0.5F}}};
}

View Funnel::view() const {
  return {btVector3(btScalar(4.4), btScalar(5.6), btScalar(7.4)), btVector3(0, btScalar(2.0), 0)};
}

}  // namespace softcd::demo
