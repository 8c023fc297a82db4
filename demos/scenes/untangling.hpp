#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// Cloths and balls that start through each other float without weight, and come apart. With Bullet alone they stay as
/// they are.
class Untangling : public Scene {
 public:
  explicit Untangling(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void mark_passed_through(const btSoftBody& /*body*/, std::vector<bool>& /*marked*/) const override {}
};

}  // namespace softcd::demo
