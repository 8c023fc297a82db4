#pragma once

#include "scenes/scene.hpp"

namespace softcd::benchmarks {

/// 100 soft balls of 1280 triangles each that drop onto a floor and each other in four layers and move towards the
/// middle: most touch several others.
class BallHeap : public demo::Scene {
 public:
  explicit BallHeap(const demo::SceneOptions& options);

  std::vector<demo::Surface> surfaces() const override;
  demo::View view() const override;

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  std::vector<const btSoftBody*> balls_;
};

}  // namespace softcd::benchmarks
