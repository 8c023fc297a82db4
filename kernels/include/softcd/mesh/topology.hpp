#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "softcd/core/types.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/triangle_edges.hpp"
#include "softcd/mesh/vertex_stars.hpp"

namespace softcd {

/// Returns lower index:32 | higher index:32, from high to low bits. Sorting these keys of vertex pairs sorts edges.
inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

/// A mesh's triangles by patches; see patch_order().
struct PatchOrder {
  /// The triangles of patch p are triangles[kPatchSize * p] and the following ones. kNoIndex fills patches of fewer
  /// triangles, never the first place.
  std::vector<std::uint32_t> triangles;
  std::uint32_t triangle_count = 0;  ///< of the mesh: each is in one patch
};

/// A mesh's connectivity, derived once per change of topology.
struct Topology {
  /// The mesh's triangles, then {v[0], v[1], v[1]} for each segment.
  std::vector<Triangle> triangles;
  /// Each pair of distinct vertices that a triangle's side joins, once, sorted by (v[0], v[1]). Then each other pair
  /// that is a segment, once, in the order of the segments.
  std::vector<Edge> edges;
  std::vector<TriangleEdges> triangle_edges;
  /// Ownership by R-triangles: every vertex and edge in use is owned by the first triangle that has it.
  std::vector<Ownership> ownership;
  PatchOrder patches;
  std::uint32_t vertex_count = 0;
  std::uint32_t segment_count = 0;  ///< the number of segments; they are the last triangles
};

/// Derives the topology of a mesh. Indices must be below vertex_count.
Topology build_topology(Span<const Triangle> triangles, std::uint32_t vertex_count, Span<const Segment> segments = {});

/// A mesh's connectivity within an array of several meshes. It has the fields of a Topology, in which vertices,
/// triangles and edges are numbered from the mesh's first ones on.
struct MeshView {
  Span<const Triangle> triangles;
  Span<const Edge> edges;
  Span<const TriangleEdges> triangle_edges;
  std::uint32_t vertex_count = 0;
  std::uint32_t first_vertex = 0, first_triangle = 0, first_edge = 0;
  std::uint32_t segment_count = 0;

  std::uint32_t face_count() const { return static_cast<std::uint32_t>(triangles.size()) - segment_count; }
};

/// Returns the view of a single mesh.
inline MeshView view_of(const Topology& topology) {
  return {topology.triangles,   topology.edges,        topology.triangle_edges, topology.vertex_count,
          /*first_vertex=*/0,
          /*first_triangle=*/0,
          /*first_edge=*/0,     topology.segment_count};
}

/// Assigns ownership among the triangles whose `left_out` flag is 0; the others own nothing. There is one flag for each
/// triangle. Also marks segments.
std::vector<Ownership> assign_ownership(const MeshView& mesh, Span<const std::uint8_t> left_out);

/// Returns whether a mesh's neighbours are listed. The number of corners around its triangles is the sum of the squares
/// of each vertex's triangle count: 18 for each triangle of a regular mesh.
inline bool has_few_corners_around(std::uint64_t corners_around, std::uint64_t triangle_count) {
  constexpr std::uint64_t kMostCornersAround = 64;
  return corners_around <= kMostCornersAround * triangle_count;
}

/// Stands for an empty slot in lists of neighbours' features.
constexpr std::uint64_t kNoFeatures = ~std::uint64_t{0};

/// Feature pairs of triangles that share a vertex. Volumes of such triangles always overlap, so every detection would
/// find the same pairs again. They are most pairs that a mesh finds with itself.
struct NeighbourFeatures {
  /// False where vertices with very many triangles would make too many; the lists are empty then.
  bool are_listed = false;
  std::vector<std::uint64_t> vertex_triangle;  ///< vertex:32 | triangle:32 from high to low
  std::vector<std::uint64_t> edge_edge;        ///< lower edge:32 | higher edge:32
  std::vector<VertexStar> stars;               ///< one for each vertex of a triangle
};

/// The ends, in NeighbourFeatures, of the pairs of one triangle and its neighbours.
struct FeatureEnds {
  std::uint32_t vertex_triangle, edge_edge;
};

/// Lists feature pairs of neighbouring triangles, each once: vertices with triangles (not segments), and pairs of
/// edges. The features share no vertex, but their owners do; `ownership` names the owners, and a triangle owns itself.
/// Features are numbered as in the mesh. Writes the pairs triangle by triangle, and the ends to `ends` unless null.
NeighbourFeatures neighbour_features(const MeshView& mesh, Span<const Ownership> ownership,
                                     std::vector<FeatureEnds>* ends = nullptr);

}  // namespace softcd
