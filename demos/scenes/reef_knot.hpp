#pragma once

#include <array>

#include "scenes/ribbon.hpp"
#include "scenes/scene.hpp"

namespace softcd::demo {

/// Two ribbons, weightless, loosely joined by a reef knot. Hands at their four ends pull them apart until the ribbons
/// are taut. Where nothing keeps the ribbons from passing through each other, they come apart.
class ReefKnot : public Scene {
 public:
  explicit ReefKnot(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  /// How far the ribbons reach past each other, negative when they have come apart.
  btScalar overlap() const;
  /// Of the four legs, on average.
  btScalar stretch() const;

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  /// At one end of a ribbon, of which a straight leg starts there.
  struct Hand {
    btSoftBody* ribbon;
    int column;
    btVector3 direction;
    StretchGauge leg;
  };

  btSoftBody& add_ribbon(btScalar direction);

  int columns_;
  std::vector<Hand> hands_;
  std::array<btSoftBody*, 2> ribbons_;
};

}  // namespace softcd::demo
