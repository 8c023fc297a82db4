#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// Computes positions and distances of a scene's features. Keeps a reference to the scene.
class SceneGeometry {
 public:
  explicit SceneGeometry(const Scene& scene);

  /// Returns a pair's four vertices: the vertex and the triangle's, or the two edges'.
  std::array<std::uint32_t, 4> vertices(const FeaturePair& pair) const;
  /// Returns their positions at t0, then at t1.
  std::array<Vec3d, 8> motion(const FeaturePair& pair) const;
  std::array<Vec3d, 4> positions(const FeaturePair& pair, double time) const;
  /// Returns the distance in long double, rounded once.
  double distance(const FeaturePair& pair, double time) const;
  /// Returns the smallest distance found near a time, against which a time of impact that was rounded to float can be
  /// checked.
  double distance_near(const FeaturePair& pair, double time) const;

  /// Returns the error in a contact itself: in its vertices, weights, normal, distance or time. Empty when there is
  /// none. `tolerance` is absolute, for the roundings of its points' coordinates and its distance.
  std::string flaw_of(const Contact& contact, Detection detection, double tolerance) const;

 private:
  const Scene& scene_;
  std::vector<std::vector<Edge>> edges_;
};

}  // namespace softcd::test
