#include "scenes/tube.hpp"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "scenes/cloth.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kTubeRadius = btScalar(0.7);
constexpr btScalar kTubeHeight = 4;
constexpr btScalar kFootHeight = btScalar(0.1);
// Offset of the middle, so that rounding does not decide where the tube buckles.
constexpr btScalar kBow = btScalar(0.1);
constexpr btScalar kTubeStiffness = btScalar(0.1);  // Bullet's, 0 to 1
constexpr btScalar kTubeMarginInCells = btScalar(1) / 4;

}  // namespace

Tube::Tube(const SceneOptions& options) : Scene(options) {
  const int columns = options.size + options.size % 2;
  const btScalar spacing = SIMD_2_PI * kTubeRadius / btScalar(columns);
  const int rows = static_cast<int>(kTubeHeight / spacing) + 1;
  ClothShape shape = vertical_tube(btVector3(0, kFootHeight, 0), kTubeRadius, kTubeHeight, columns, rows);
  shape.position = [=, straight = shape.position](int column, int row) {
    const btScalar bow = kBow * btSin(SIMD_PI * btScalar(row) / btScalar(rows - 1));
    return straight(column, row) + btVector3(bow, 0, 0);
  };
  shape.is_fixed = [](int, int row) { return row == 0; };
  shape.resists_bending = false;

  auto tube = make_cloth(simulation().world_info(), shape, 1);
  tube->getCollisionShape()->setMargin(kTubeMarginInCells * spacing);
  tube->setSelfCollision(true);
  tube->m_materials[0]->m_kLST = kTubeStiffness;
  tube->m_cfg.kDF = btScalar(0.4);
  tube->m_cfg.kDP = btScalar(0.02);
  tube->m_cfg.kKHR = 1;
  tube->m_cfg.piterations = 8;
  tube_ = &add(std::move(tube));
  simulation().add_rigid(std::make_unique<btBoxShape>(btVector3(4, 1, 4)), btVector3(0, -1, 0));
}

void Tube::mark_passed_through(const btSoftBody& /*body*/, std::vector<bool>& /*marked*/) const {}

std::vector<Surface> Tube::surfaces() const {
  return {{tube_, {0.45F, 0.08F, 0.30F}, {0.70F, 0.55F, 0.20F}}};
}

View Tube::view() const {
  return {btVector3(btScalar(4.3), btScalar(4.8), btScalar(6.2)), btVector3(0, btScalar(1.8), 0)};
}

}  // namespace softcd::demo
