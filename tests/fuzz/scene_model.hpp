#pragma once

#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// Records the calls of a scene. Its results are compared with those of a new scene with the same state, and with brute
/// force.
class SceneModel {
 public:
  struct Body {
    BodyId id;
    SceneBody mesh;
    bool has_positions = false;
  };

  std::vector<Body> bodies;  ///< by id, ascending

  std::vector<Contact> fresh_contacts(const QueryOptions& options, const PairFilter& filter) const;
  std::vector<RayHit> fresh_hits(Span<const Ray> rays, StepEnd end) const;
  std::vector<ClosestPoint> fresh_closest_points(Span<const ProbePoint> points, StepEnd end) const;

  /// Compares contacts with brute force, where that is quick and exact: none is missing, and no discrete contact is
  /// false.
  void require_what_brute_force_finds(const QueryOptions& options, Span<const Contact> contacts) const;

 private:
  softcd::Scene fresh_scene() const;
  Scene needed_positions(const QueryOptions& options) const;
};

}  // namespace softcd::test
