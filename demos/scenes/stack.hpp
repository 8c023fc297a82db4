#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// Cloths, each turned a little, hang in the air one above the other. They fall and come to rest on the lowest one,
/// which is held along its border.
class Stack : public Scene {
 public:
  static constexpr int kCloths = 8;

  explicit Stack(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  /// Returns a cloth. Number 0 is the lowest one.
  btSoftBody& cloth(int number) { return *cloths_[static_cast<std::size_t>(number)]; }

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  std::vector<btSoftBody*> cloths_;
};

}  // namespace softcd::demo
