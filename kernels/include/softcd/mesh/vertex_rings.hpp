#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Lists the vertices that are near each other on a mesh. For vertex v, counted from 0 within the mesh, they are
/// vertices[begin[v]] up to, but without, vertices[begin[v + 1]], ascending. They are numbered as in the mesh, and do
/// not include v.
struct VertexRings {
  std::vector<std::uint64_t> begin;
  std::vector<std::uint32_t> vertices;
};

/// Returns for each vertex the other vertices that a path of at most `edge_count` edges leads to.
VertexRings vertex_rings(const MeshView& mesh, std::uint32_t edge_count);

}  // namespace softcd
