#pragma once

#include "scenes/changing_cloth.hpp"

namespace softcd::demo {

/// A coarse sheet falls over a ball. Where it folds, its triangles are halved at their longest edges, repeatedly, until
/// they are fine enough.
class Refining : public ChangingCloth {
 public:
  explicit Refining(const SceneOptions& options);

  View view() const override;

 protected:
  std::vector<Edge> edges_to_change() const override;
  bool change_at(const Edge& edge) override;
};

}  // namespace softcd::demo
