#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// Cloths that hang in the air one above the other, each turned a little, fall and come to rest on each other, the
/// lowest one being held along its border.
class Stack : public Scene {
 public:
  static constexpr int kCloths = 8;

  explicit Stack(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  /// Number 0 is the lowest one.
  btSoftBody& cloth(int number) { return *cloths_[static_cast<std::size_t>(number)]; }

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  std::vector<btSoftBody*> cloths_;
};

}  // namespace softcd::demo
