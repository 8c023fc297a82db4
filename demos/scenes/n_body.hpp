#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// Soft balls, as many as the size says, fall in layers onto cones of a few large triangles, onto the floor and onto
/// each other.
class NBody : public Scene {
 public:
  explicit NBody(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  void add_cones();
  void add_balls(int count);

  std::vector<btSoftBody*> cones_;
  std::vector<btSoftBody*> balls_;
  btScalar top_ = 0;  ///< of the highest ball at the start
};

}  // namespace softcd::demo
