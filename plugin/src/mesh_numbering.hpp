#pragma once

#include <cstdint>

#include "softcd/core/types.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/triangle_edges.hpp"

// Converts indices: a mesh alone numbers its vertices and edges from 0, a scene's arrays from the mesh's first ones.
namespace softcd {

inline Triangle renumbered(const Triangle& triangle, std::uint32_t by) {
  return {{triangle.v[0] + by, triangle.v[1] + by, triangle.v[2] + by}};
}

inline Edge renumbered(const Edge& edge, std::uint32_t by) {
  return {{edge.v[0] + by, edge.v[1] + by}};
}

inline TriangleEdges renumbered(const TriangleEdges& edges, std::uint32_t by) {
  const auto renumber = [by](std::uint32_t e) { return e == kNoIndex ? kNoIndex : e + by; };
  return {{renumber(edges.e[0]), renumber(edges.e[1]), renumber(edges.e[2])}};
}

}  // namespace softcd
