#pragma once

#include <cstdint>

#include "softcd/core/types.hpp"

/// The vertices and edges of triangles, and which triangle tests them.
namespace softcd {

/// Returns whether `v` is one of the three.
SOFTCD_HD constexpr bool has_vertex(const Triangle& triangle, std::uint32_t v) {
  return (v == triangle.v[0]) | (v == triangle.v[1]) | (v == triangle.v[2]);
}

/// Returns whether two triangles of one mesh have a vertex in common.
SOFTCD_HD constexpr bool share_vertex(const Triangle& a, const Triangle& b) {
  const bool has_first = has_vertex(b, a.v[0]);
  const bool has_second = has_vertex(b, a.v[1]);
  const bool has_third = has_vertex(b, a.v[2]);
  return has_first | has_second | has_third;
}

/// Two vertex indices, v[0] < v[1].
struct Edge {
  std::uint32_t v[2];
};

/// Bits that say which vertices and edges a triangle owns (R-triangles, Curtis, Tamstorf, Manocha 2008). Bit i is
/// vertex v[i], bit 3 + i is the edge v[i], v[(i + 1) % 3].
using Ownership = std::uint8_t;

/// The bit that marks a segment, beside those of the features that it owns: it has no face that vertices could touch.
constexpr std::uint32_t kSegment = 0x40u;

/// The only bit of a triangle that is left out because one of its vertices is not finite.
constexpr std::uint32_t kLeftOut = 0x80u;

}  // namespace softcd
