#include "scenes/stack.hpp"

#include <utility>

#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kHeldSide = 5;
constexpr btScalar kStackSide = 4;
constexpr btScalar kStackHeight = btScalar(2.5);  // of the lowest cloth
constexpr btScalar kGap = btScalar(0.3);
constexpr btScalar kStackTurn = btScalar(0.4);          // radians, from cloth to cloth
constexpr btScalar kStackMassPerArea = btScalar(0.05);  // kilograms
constexpr btScalar kStackMarginInCells = btScalar(1) / 4;

std::unique_ptr<btSoftBody> make_configured(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar side) {
  auto cloth = make_cloth(world_info, shape, kStackMassPerArea * side * side);
  cloth->getCollisionShape()->setMargin(kStackMarginInCells * kStackSide / btScalar(shape.columns - 1));
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  cloth->m_cfg.piterations = 6;
  return cloth;
}

}  // namespace

Stack::Stack(const SceneOptions& options) : Scene(options) {
  const int nodes = options.size;
  ClothShape held = horizontal_cloth(nodes, kHeldSide, kStackHeight);
  held.is_fixed = [last = nodes - 1](int column, int row) {
    return column == 0 || row == 0 || column == last || row == last;
  };
  cloths_.push_back(&add(make_configured(simulation().world_info(), held, kHeldSide)));
  for (int number = 1; number < kCloths; ++number) {
    auto cloth =
        make_configured(simulation().world_info(),
                        horizontal_cloth(nodes, kStackSide, kStackHeight + kGap * btScalar(number)), kStackSide);
    cloth->rotate(btQuaternion(btVector3(0, 1, 0), kStackTurn * btScalar(number)));
    cloths_.push_back(&add(std::move(cloth)));
  }
}

void Stack::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  for (std::size_t number = 1; number < cloths_.size(); ++number) {
    if (&body == cloths_[number]) mark_below(*cloths_[number - 1], body, marked);
  }
}

std::vector<Surface> Stack::surfaces() const {
  constexpr Color kFronts[] = {{0.10F, 0.28F, 0.42F}, {0.60F, 0.30F, 0.05F}, {0.10F, 0.32F, 0.22F}};
  constexpr Color kBack = {0.45F, 0.42F, 0.35F};
  std::vector<Surface> surfaces;
  for (std::size_t number = 0; number < cloths_.size(); ++number) {
    surfaces.push_back({cloths_[number], kFronts[number % std::size(kFronts)], kBack});
  }
  return surfaces;
}

View Stack::view() const {
  return {btVector3(btScalar(5.0), btScalar(6.0), btScalar(7.0)), btVector3(0, btScalar(2.3), 0)};
}

}  // namespace softcd::demo
