#include "softcd/mesh/topology.hpp"

#include <algorithm>

namespace softcd {
namespace {

/// v[0]:32 | v[1]:32 from high to low, so that sorting keys sorts edges.
std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

}  // namespace

Topology build_topology(Span<const Triangle> triangles, std::uint32_t vertex_count) {
  Topology topology;
  topology.vertex_count = vertex_count;
  topology.triangles.assign(triangles.begin(), triangles.end());

  std::vector<std::uint64_t> keys;
  keys.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles) {
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t a = triangle.v[side];
      const std::uint32_t b = triangle.v[(side + 1) % 3];
      if (a != b) keys.push_back(edge_key(a, b));
    }
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  topology.edges.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    topology.edges.push_back({{static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)}});
  }
  topology.triangle_edges.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    Triangle edges{};
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t a = triangle.v[side];
      const std::uint32_t b = triangle.v[(side + 1) % 3];
      const auto found = std::lower_bound(keys.begin(), keys.end(), edge_key(a, b));
      edges.v[side] = a == b ? kNoIndex : static_cast<std::uint32_t>(found - keys.begin());
    }
    topology.triangle_edges.push_back(edges);
  }
  topology.ownership = assign_ownership(topology, std::vector<std::uint8_t>(triangles.size(), 0));
  return topology;
}

std::vector<Ownership> assign_ownership(const Topology& topology, Span<const std::uint8_t> left_out) {
  std::vector<Ownership> ownership(topology.triangles.size(), 0);
  std::vector<bool> vertex_owned(topology.vertex_count, false);
  std::vector<bool> edge_owned(topology.edges.size(), false);
  for (std::size_t t = 0; t < topology.triangles.size(); ++t) {
    if (left_out[t] != 0) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = topology.triangles[t].v[corner];
      if (!vertex_owned[vertex]) ownership[t] |= static_cast<Ownership>(1U << corner);
      vertex_owned[vertex] = true;
      const std::uint32_t edge = topology.triangle_edges[t].v[corner];
      if (edge == kNoIndex) continue;
      if (!edge_owned[edge]) ownership[t] |= static_cast<Ownership>(8U << corner);
      edge_owned[edge] = true;
    }
  }
  return ownership;
}

}  // namespace softcd
