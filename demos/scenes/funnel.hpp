#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A square cloth falls into a funnel. Its middle is pulled down through the spout until all of it lies on the floor.
class Funnel : public Scene {
 public:
  explicit Funnel(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  btSoftBody* cloth_;
  btSoftBody* funnel_;
  std::vector<int> pulled_;  ///< nodes
};

}  // namespace softcd::demo
