#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// An elastic tube stands on the floor between two rings of held nodes. The upper ring sinks and turns; the wall
/// buckles and lies in folds on itself.
class Tube : public Scene {
 public:
  explicit Tube(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  btSoftBody& tube() { return *tube_; }

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  btSoftBody* tube_;
  int columns_;
  int rows_;
};

}  // namespace softcd::demo
