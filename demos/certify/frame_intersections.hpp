#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "certificate.hpp"
#include "mesh_sequence.hpp"
#include "softcd/softcd.hpp"

namespace softcd::demo {

/// Finds the triangles that have a point in common with each other, in exact arithmetic of the positions as given.
class FrameIntersections {
 public:
  /// `scene` must outlive the object. Mesh i of `meshes` is body i of `bodies`, with positions from previous() to
  /// current().
  FrameIntersections(Scene& scene, const std::vector<BodyId>& bodies) : probe_(scene), bodies_(bodies) {}

  /// Compares the triangles of mesh 0 with each other and with those of all other meshes, at the end of the step.
  /// Returns pairs in ascending order.
  std::vector<TrianglePair> find(const std::vector<MeshSequence>& meshes);

 private:
  /// Receives a triangle of mesh 0, and another mesh with a triangle of it.
  using Visit = std::function<void(std::uint32_t triangle_a, std::uint32_t mesh_b, std::uint32_t triangle_b)>;

  /// Passes all pairs that have a point in common to `visit`. Only for positions that are floats: the scene does not
  /// round these.
  void visit_intersecting(const Visit& visit);
  /// Passes all pairs that may have a point in common to `visit`.
  void visit_near(const std::vector<MeshSequence>& meshes, const Visit& visit);
  std::uint32_t mesh_of(BodyId body) const;

  Probe probe_;
  std::vector<BodyId> bodies_;
};

}  // namespace softcd::demo
