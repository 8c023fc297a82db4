#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A soft tube, held at its foot, cannot bear its own weight: its wall gives way from below and lies in folds on
/// itself.
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
