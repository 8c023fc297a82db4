#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "softcd/core/types.hpp"
#include "softcd/mesh/triangle_edges.hpp"

namespace softcd {

/// The lower index:32 | the higher:32 from high to low: of vertices, sorting keys sorts edges.
inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

/// A mesh's connectivity, derived once per change of topology.
struct Topology {
  /// Those of the mesh, then {v[0], v[1], v[1]} for each segment.
  std::vector<Triangle> triangles;
  /// Every pair of distinct vertices joined by a triangle's side, once, sorted by (v[0], v[1]); then every other one
  /// that is a segment, once, in the order of the segments.
  std::vector<Edge> edges;
  std::vector<TriangleEdges> triangle_edges;
  /// R-triangles: every vertex and edge that occurs is owned by the first triangle that has it.
  std::vector<Ownership> ownership;
  std::uint32_t vertex_count = 0;
  std::uint32_t segment_count = 0;  ///< of the triangles, the last ones
};

/// Indices must be below vertex_count.
Topology build_topology(Span<const Triangle> triangles, std::uint32_t vertex_count, Span<const Segment> segments = {});

/// A mesh's connectivity where it lies among other meshes: the fields of a Topology, in which vertices, triangles and
/// edges are numbered from the mesh's first ones on.
struct MeshView {
  Span<const Triangle> triangles;
  Span<const Edge> edges;
  Span<const TriangleEdges> triangle_edges;
  std::uint32_t vertex_count = 0;
  std::uint32_t first_vertex = 0, first_triangle = 0, first_edge = 0;
  std::uint32_t segment_count = 0;

  std::uint32_t face_count() const { return static_cast<std::uint32_t>(triangles.size()) - segment_count; }
};

/// The view of a mesh on its own.
inline MeshView view_of(const Topology& topology) {
  return {topology.triangles,   topology.edges,        topology.triangle_edges, topology.vertex_count,
          /*first_vertex=*/0,
          /*first_triangle=*/0,
          /*first_edge=*/0,     topology.segment_count};
}

/// Ownership among the triangles whose `left_out` flag is 0; the others own nothing. Flags: one per triangle. Segments
/// are told.
std::vector<Ownership> assign_ownership(const MeshView& mesh, Span<const std::uint8_t> left_out);

/// Whether a mesh's neighbours are listed: corners around its triangles are the sum of the squares of how many
/// triangles each vertex has, 18 to a triangle in a regular mesh.
inline bool has_few_corners_around(std::uint64_t corners_around, std::uint64_t triangle_count) {
  constexpr std::uint64_t kMostCornersAround = 64;
  return corners_around <= kMostCornersAround * triangle_count;
}

/// Stands in lists of neighbours' features for none.
constexpr std::uint64_t kNoFeatures = ~std::uint64_t{0};

/// What a mesh's triangles that share a vertex have to be tested for. Their volumes always overlap, so that every
/// detection would find the same pairs again: most of what a mesh finds with itself.
struct NeighbourFeatures {
  /// False where vertices with very many triangles would make too many; the lists are empty then.
  bool are_listed = false;
  std::vector<std::uint64_t> vertex_triangle;  ///< vertex:32 | triangle:32 from high to low
  std::vector<std::uint64_t> edge_edge;        ///< lower edge:32 | higher edge:32
};

/// Where what NeighbourFeatures list of one triangle and its neighbours ends.
struct FeatureEnds {
  std::uint32_t vertex_triangle, edge_edge;
};

/// Every vertex with every triangle but segments, and every two edges, whose owner (`ownership`; of a triangle itself)
/// shares a vertex with the other's while they do not, each once. Numbered as in the mesh. Triangle by triangle, whose
/// `ends` are told where they are asked for.
NeighbourFeatures neighbour_features(const MeshView& mesh, Span<const Ownership> ownership,
                                     std::vector<FeatureEnds>* ends = nullptr);

}  // namespace softcd
