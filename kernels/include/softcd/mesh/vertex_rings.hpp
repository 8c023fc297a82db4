#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Which vertices of a mesh are near each other on it: for vertex v of the mesh, counted from 0, vertices[begin[v]] to,
/// without it, vertices[begin[v + 1]], ascending, numbered as in the mesh; v itself is not among them.
struct VertexRings {
  std::vector<std::uint64_t> begin;
  std::vector<std::uint32_t> vertices;
};

/// For each vertex the others that a path of at most `edge_count` edges leads to.
VertexRings vertex_rings(const MeshView& mesh, std::uint32_t edge_count);

}  // namespace softcd
