#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

struct LowerAndUpperCloth {
  std::unique_ptr<btSoftBody> lower, upper;
};

/// The bodies of TwoCloths, for any world.
LowerAndUpperCloth make_two_cloths(btSoftBodyWorldInfo& world_info, int nodes_per_side);

/// A cloth, slightly turned, falls onto another one of the same size that is held along its border.
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
