#pragma once

#include "scenes/scene.hpp"

namespace softcd::demo {

/// Two round cloths whose triangles grow from the middle to the border, by 10,000 in area. One is held along its
/// border; the other falls onto it, its small triangles onto the large ones of the first.
class MixedSizesCloth : public Scene {
 public:
  explicit MixedSizesCloth(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  btSoftBody* lower_;
  btSoftBody* upper_;
};

/// Small balls of small triangles, as many as the size says, fall between boulders of 20
/// triangles each, 10,000 times as large.
class MixedSizesBalls : public Scene {
 public:
  explicit MixedSizesBalls(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

 protected:
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  std::vector<btSoftBody*> boulders_;
  std::vector<btSoftBody*> balls_;
};

}  // namespace softcd::demo
