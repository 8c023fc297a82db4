#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A long cloth, folded into four loose layers. Its lowest layer is held; the others fall onto it and onto each other.
/// Without self-collision they fall through.
class FoldingCloth : public Scene {
 public:
  static constexpr int kLayers = 4;

  explicit FoldingCloth(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  btSoftBody& cloth() { return *cloth_; }
  /// Returns the mean height of a layer's flat part above the layer below it. The lowest layer has number 0.
  btScalar mean_gap_below(int layer) const;

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  /// Returns the node of `layer` that was `cells` cells away from the layer's first column. In all layers that column
  /// is on the same vertical line.
  int node_in_layer(int layer, int cells, int row) const;

  btSoftBody* cloth_;
  int flat_cells_;  ///< along a layer
  int bend_cells_;  ///< along the half circle between two layers
  int columns_;
  int rows_;
};

}  // namespace softcd::demo
