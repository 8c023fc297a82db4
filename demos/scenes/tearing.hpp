#pragma once

#include "scenes/changing_cloth.hpp"

namespace softcd::demo {

/// A ball is driven through a cloth that is held at its corners and tears where it is stretched.
class Tearing : public ChangingCloth {
 public:
  explicit Tearing(const SceneOptions& options);

  View view() const override;

 protected:
  void animate() override;
  std::vector<Edge> edges_to_change() const override;
  bool change_at(const Edge& edge) override;
};

}  // namespace softcd::demo
