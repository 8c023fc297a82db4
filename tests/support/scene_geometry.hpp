#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// Where a scene's features are. Keeps a reference to the scene.
class SceneGeometry {
 public:
  explicit SceneGeometry(const Scene& scene);

  /// A pair's four vertices: the vertex and the triangle's, or the two edges'.
  std::array<std::uint32_t, 4> vertices(const FeaturePair& pair) const;
  /// Their positions at t0, then at t1.
  std::array<Vec3d, 8> motion(const FeaturePair& pair) const;
  std::array<Vec3d, 4> positions(const FeaturePair& pair, double time) const;
  /// In long double, rounded once.
  double distance(const FeaturePair& pair, double time) const;
  /// The smallest distance found near a time: what a time of impact that was rounded to float can be held to.
  double distance_near(const FeaturePair& pair, double time) const;

  /// What is wrong with a contact in itself: its vertices, weights, normal, distance or time. Empty when nothing is.
  /// `tolerance` is absolute, for what its points' coordinates and its distance went through.
  std::string flaw_of(const Contact& contact, Detection detection, double tolerance) const;

 private:
  const Scene& scene_;
  std::vector<std::vector<Edge>> edges_;
};

}  // namespace softcd::test
