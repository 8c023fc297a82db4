#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A square cloth falls onto a ball that turns about the vertical axis from the second second on. Friction drags
/// the cloth along; its hanging parts lag behind and fold. The cloth collides with itself.
class ClothOnBall : public Scene {
 public:
  explicit ClothOnBall(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  /// Returns the angle in radians at the given time.
  static btScalar angle_at(btScalar time);

  btSoftBody* cloth_;
  btSoftBody* ball_;
  std::vector<btVector3> ball_at_rest_;  ///< the ball's nodes before it turns
};

}  // namespace softcd::demo
