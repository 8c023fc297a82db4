#include "scenes/tube.hpp"

#include <algorithm>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "scenes/cloth.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kRadius = btScalar(0.7);
constexpr btScalar kHeight = btScalar(3.2);
constexpr btScalar kFootHeight = btScalar(0.1);
constexpr btScalar kSinkingRate = btScalar(0.8);  // units a second
constexpr btScalar kLowestLid = btScalar(1.1);
constexpr btScalar kTurnPerUnit = btScalar(0.4);  // radians of the lid, by which it has sunk
constexpr btScalar kMarginInCells = btScalar(1) / 4;

}  // namespace

Tube::Tube(const SceneOptions& options) : Scene(options) {
  columns_ = options.size + options.size % 2;
  const btScalar spacing = SIMD_2_PI * kRadius / btScalar(columns_);
  rows_ = static_cast<int>(kHeight / spacing) + 1;
  ClothShape shape = vertical_tube(btVector3(0, kFootHeight, 0), kRadius, kHeight, columns_, rows_);
  shape.is_fixed = [last = rows_ - 1](int, int row) { return row == 0 || row == last; };

  auto tube = make_cloth(simulation().world_info(), shape, 1);
  tube->getCollisionShape()->setMargin(kMarginInCells * spacing);
  tube->setSelfCollision(true);
  tube->m_cfg.kDF = btScalar(0.4);
  tube->m_cfg.kDP = btScalar(0.02);
  tube->m_cfg.kKHR = 1;
  tube->m_cfg.piterations = 8;
  tube_ = &add(std::move(tube));
  simulation().add_static(std::make_unique<btBoxShape>(btVector3(4, 1, 4)), btVector3(0, -1, 0));
}

void Tube::animate() {
  const btScalar lid = tube_->m_nodes[columns_ * (rows_ - 1)].m_x.y();
  const bool is_down = lid <= kLowestLid;
  for (int i = columns_ * (rows_ - 1); i < tube_->m_nodes.size(); ++i) {
    btSoftBody::Node& node = tube_->m_nodes[i];
    const btVector3 turning = btVector3(0, kTurnPerUnit, 0).cross(node.m_x) + btVector3(0, -1, 0);
    node.m_v = is_down ? btVector3(0, 0, 0) : kSinkingRate * turning;
  }
}

void Tube::mark_passed_through(const btSoftBody& /*body*/, std::vector<bool>& /*marked*/) const {}

std::vector<Surface> Tube::surfaces() const {
  return {{tube_, {0.45F, 0.08F, 0.30F}, {0.70F, 0.55F, 0.20F}}};
}

View Tube::view() const {
  return {btVector3(btScalar(4.0), btScalar(4.6), btScalar(5.8)), btVector3(0, btScalar(1.5), 0)};
}

}  // namespace softcd::demo
