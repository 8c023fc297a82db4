#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// A cloth, turned by some degrees, falls onto another one of the same size that is held along its border.
class TwoCloths : public Scene {
 public:
  explicit TwoCloths(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  btSoftBody& upper() { return *upper_; }
  btSoftBody& lower() { return *lower_; }

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  btSoftBody* lower_;
  btSoftBody* upper_;
};

}  // namespace softcd::demo
