#pragma once

#include <cstdint>

#include "softcd/core/span.hpp"
#include "softcd/core/types.hpp"

namespace softcd {

/// Most triangles around a vertex whose star is tested as a whole.
constexpr std::uint32_t kMostTrianglesOfStar = 8;

/// A vertex's star: the triangles around it. Each is {centre, ring[i], ring[i + 1]}, in either orientation. Around an
/// inner vertex the last of the ring is the first again. kNoIndex fills the rest of the ring, and all of it if the
/// triangles do not form one fan or are too many.
struct VertexStar {
  std::uint32_t centre;
  std::uint32_t ring[kMostTrianglesOfStar + 1];
};

/// Returns the star of a vertex with these triangles, which all have it.
VertexStar star_of(std::uint32_t vertex, Span<const Triangle> triangles);

}  // namespace softcd
