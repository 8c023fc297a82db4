#include "scenes/two_cloths.hpp"

#include <utility>

#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kTwoClothsSide = 6;
constexpr btScalar kTwoClothsHeight = 3;
constexpr btScalar kTwoClothsDrop = btScalar(0.3);
constexpr btScalar kTwoClothsTurn = btScalar(0.35);  // radians

std::unique_ptr<btSoftBody> make_configured(btSoftBodyWorldInfo& world_info, const ClothShape& shape) {
  auto cloth = make_cloth(world_info, shape, 2);
  cloth->getCollisionShape()->setMargin(kTwoClothsSide / btScalar(shape.columns - 1) / 4);
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  cloth->m_cfg.piterations = 4;
  return cloth;
}

}  // namespace

LowerAndUpperCloth make_two_cloths(btSoftBodyWorldInfo& world_info, int nodes_per_side) {
  const int last = nodes_per_side - 1;
  ClothShape held = horizontal_cloth(nodes_per_side, kTwoClothsSide, kTwoClothsHeight);
  held.is_fixed = [last](int column, int row) { return column == 0 || row == 0 || column == last || row == last; };
  auto falling =
      make_configured(world_info, horizontal_cloth(nodes_per_side, kTwoClothsSide, kTwoClothsHeight + kTwoClothsDrop));
  falling->rotate(btQuaternion(btVector3(0, 1, 0), kTwoClothsTurn));
  return {make_configured(world_info, held), std::move(falling)};
}

TwoCloths::TwoCloths(const SceneOptions& options) : Scene(options) {
  LowerAndUpperCloth cloths = make_two_cloths(simulation().world_info(), options.size);
  lower_ = &add(std::move(cloths.lower));
  upper_ = &add(std::move(cloths.upper));
  for (btSoftBody* cloth : {lower_, upper_}) cloth->setSelfCollision(true);
}

void TwoCloths::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body == upper_) mark_below(*lower_, body, marked);
}

std::vector<Surface> TwoCloths::surfaces() const {
  return {{lower_, {0.10F, 0.28F, 0.42F}, {0.35F, 0.42F, 0.45F}}, {upper_, {0.60F, 0.30F, 0.05F}, {0.5F, 0.1F, 0.1F}}};
}

View TwoCloths::view() const {
  return {btVector3(btScalar(5.5), btScalar(6.5), btScalar(8)), btVector3(0, btScalar(2.2), 0)};
}

}  // namespace softcd::demo
