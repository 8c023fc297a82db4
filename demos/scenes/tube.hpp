#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A soft tube, held at its foot, that cannot bear its own weight: its wall buckles from below and folds onto itself.
class Tube : public Scene {
 public:
  explicit Tube(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  btSoftBody& tube() { return *tube_; }

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  btSoftBody* tube_;
};

}  // namespace softcd::demo
