#pragma once

#include <algorithm>
#include <cstdint>

#include "softcd/mesh/features.hpp"
#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Calls visit(n) for every triangle n other than t that shares a vertex with it, once.
template <class VertexTriangles, class Visit>
void for_each_neighbour(const MeshView& mesh, const VertexTriangles& triangles_of, std::uint32_t t, Visit visit) {
  const auto& v = mesh.triangles[t].v;
  for (int corner = 0; corner < 3; ++corner) {
    triangles_of.for_each_triangle_of(v[corner], [&](std::uint32_t other) {
      const Triangle& triangle = mesh.triangles[other];
      const bool was_visited =
          std::any_of(v, v + corner, [&](std::uint32_t before) { return has_vertex(triangle, before); });
      if (other != t && !was_visited) visit(other);
    });
  }
}

/// Lists the features of pairs of neighbouring triangles, one pair at a time.
class NeighbourLister {
 public:
  NeighbourLister(const MeshView& mesh, Span<const Ownership> ownership, NeighbourFeatures& out)
      : mesh_(mesh), ownership_(ownership), out_(out) {}

  void add(std::uint32_t t, std::uint32_t neighbour) {
    add_vertices(neighbour, t);
    if (neighbour > t) add_edges(t, neighbour);
  }

 private:
  void add_vertices(std::uint32_t owner, std::uint32_t t) {
    if ((ownership_[t] & kSegment) != 0) return;
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = mesh_.triangles[owner].v[corner];
      const bool is_owned = (ownership_[owner] & (1U << corner)) != 0;
      if (is_owned && !has_vertex(mesh_.triangles[t], v)) {
        out_.vertex_triangle.push_back((static_cast<std::uint64_t>(v) << 32) | (mesh_.first_triangle + t));
      }
    }
  }

  void add_edges(std::uint32_t a, std::uint32_t b) {
    for (int side_a = 0; side_a < 3; ++side_a) {
      if ((ownership_[a] & (8U << side_a)) == 0) continue;
      for (int side_b = 0; side_b < 3; ++side_b) {
        if ((ownership_[b] & (8U << side_b)) == 0) continue;
        add_edge_pair(mesh_.triangle_edges[a].e[side_a], mesh_.triangle_edges[b].e[side_b]);
      }
    }
  }

  void add_edge_pair(std::uint32_t e, std::uint32_t g) {
    const auto [p, q] = mesh_.edges[e - mesh_.first_edge].v;
    const auto [r, s] = mesh_.edges[g - mesh_.first_edge].v;
    if (p != r && p != s && q != r && q != s) out_.edge_edge.push_back(edge_key(e, g));
  }

  const MeshView& mesh_;
  Span<const Ownership> ownership_;
  NeighbourFeatures& out_;
};

}  // namespace softcd
