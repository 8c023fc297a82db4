#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A dancer, turned on a lathe, who turns to and fro, sways and swings her legs in a skirt of several layers. Each
/// layer is fixed at the waist and collides with itself and with the others.
class Flamenco : public Scene {
 public:
  explicit Flamenco(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  /// Returns the position, at the given time, of a point of the dancer at rest.
  static btVector3 pose(const btVector3& at_rest, btScalar time);
  void add_dancer(btScalar spacing, btScalar margin);
  void add_layer(int layer, int rows, int columns, btScalar margin);

  btSoftBody* dancer_;
  std::vector<btVector3> dancer_at_rest_;
  int columns_ = 0;  ///< of each layer; its first nodes are fixed
  std::vector<btSoftBody*> layers_;
  std::vector<std::vector<btVector3>> waists_at_rest_;
};

}  // namespace softcd::demo
