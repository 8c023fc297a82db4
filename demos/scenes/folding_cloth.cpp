#include "scenes/folding_cloth.hpp"

#include <algorithm>

#include "scenes/cloth.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kFoldingClothSide = 3;    // of a layer
constexpr btScalar kFoldingClothHeight = 1;  // of the lowest layer
constexpr btScalar kFoldingClothLayerGap = btScalar(0.3);
constexpr btScalar kFoldingClothMarginInCells = btScalar(1) / 4;

}  // namespace

FoldingCloth::FoldingCloth(const SceneOptions& options) : Scene(options) {
  rows_ = options.size;
  flat_cells_ = options.size - 1;
  const btScalar spacing = kFoldingClothSide / btScalar(flat_cells_);
  const btScalar bend_length = SIMD_HALF_PI * kFoldingClothLayerGap;
  bend_cells_ = std::max(2, static_cast<int>(bend_length / spacing + btScalar(0.5)));
  const int layer_cells = flat_cells_ + bend_cells_;
  columns_ = kLayers * layer_cells - bend_cells_ + 1;

  ClothShape shape;
  shape.columns = columns_;
  shape.rows = rows_;
  shape.position = [=, this](int column, int row) {
    const int layer = column / layer_cells;
    const int cells = column % layer_cells;
    const bool backwards = layer % 2 == 1;
    btScalar x = spacing * btScalar(std::min(cells, flat_cells_));
    btScalar y = kFoldingClothHeight + kFoldingClothLayerGap * btScalar(layer);
    if (cells > flat_cells_) {
      const btScalar angle = SIMD_PI * btScalar(cells - flat_cells_) / btScalar(bend_cells_);
      x += kFoldingClothLayerGap / 2 * btSin(angle);
      y += kFoldingClothLayerGap / 2 * (1 - btCos(angle));
    }
    if (backwards) x = kFoldingClothSide - x;
    return btVector3(x - kFoldingClothSide / 2, y, spacing * btScalar(row) - kFoldingClothSide / 2);
  };
  shape.is_fixed = [this](int column, int) { return column <= flat_cells_; };

  auto cloth = make_cloth(simulation().world_info(), shape, 2);
  cloth->getCollisionShape()->setMargin(kFoldingClothMarginInCells * spacing);
  cloth->setSelfCollision(true);
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  cloth->m_cfg.piterations = 6;
  cloth_ = &add(std::move(cloth));
}

int FoldingCloth::node_in_layer(int layer, int cells, int row) const {
  const int along = layer % 2 == 0 ? cells : flat_cells_ - cells;
  return row * columns_ + layer * (flat_cells_ + bend_cells_) + along;
}

btScalar FoldingCloth::mean_gap_below(int layer) const {
  btScalar sum = 0;
  for (int row = 0; row < rows_; ++row) {
    for (int cells = 0; cells <= flat_cells_; ++cells) {
      sum += cloth_->m_nodes[node_in_layer(layer, cells, row)].m_x.y() -
             cloth_->m_nodes[node_in_layer(layer - 1, cells, row)].m_x.y();
    }
  }
  return sum / btScalar(rows_ * (flat_cells_ + 1));
}

void FoldingCloth::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  for (int layer = 1; layer < kLayers; ++layer) {
    for (int row = 0; row < rows_; ++row) {
      for (int cells = 0; cells <= flat_cells_; ++cells) {
        const int upper = node_in_layer(layer, cells, row);
        const int lower = node_in_layer(layer - 1, cells, row);
        if (body.m_nodes[upper].m_x.y() < body.m_nodes[lower].m_x.y()) marked[static_cast<std::size_t>(upper)] = true;
      }
    }
  }
}

std::vector<Surface> FoldingCloth::surfaces() const {
  return {{cloth_, {0.10F, 0.32F, 0.22F}, {0.65F, 0.45F, 0.12F}}};
}

View FoldingCloth::view() const {
  return {btVector3(btScalar(3.4), btScalar(3.2), btScalar(4.6)), btVector3(0, btScalar(1.0), 0)};
}

}  // namespace softcd::demo
