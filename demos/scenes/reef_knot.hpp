#pragma once

#include <array>

#include "scenes/ribbon.hpp"
#include "scenes/scene.hpp"

namespace softcd::demo {

/// Two weightless ribbons, loosely joined by a reef knot. Hands at their four ends pull them apart until the ribbons
/// are taut. If the ribbons can pass through each other, they come apart.
class ReefKnot : public Scene {
 public:
  explicit ReefKnot(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  /// Returns how far the ribbons reach past each other; negative after they have come apart.
  btScalar overlap() const;
  /// Returns the mean stretch of the four legs.
  btScalar stretch() const;

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  /// A hand at one end of a ribbon, where a straight leg starts.
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
