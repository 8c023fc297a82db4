#include "softcd/mesh/vertex_stars.hpp"

#include <algorithm>
#include <array>

namespace softcd {
namespace {

/// The corners of a triangle other than a star's centre.
struct OuterEdge {
  std::uint32_t a, b;

  bool has(std::uint32_t v) const { return a == v || b == v; }
};

using OuterEdges = std::array<OuterEdge, kMostTrianglesOfStar>;

OuterEdge outer_edge(const Triangle& triangle, std::uint32_t centre) {
  const std::uint32_t corner = triangle.v[0] == centre ? 0 : triangle.v[1] == centre ? 1 : 2;
  return {triangle.v[(corner + 1) % 3], triangle.v[(corner + 2) % 3]};
}

/// Returns an end of the fan, or any vertex if the fan is closed; kNoIndex if the edges form no fan.
std::uint32_t first_of_ring(const OuterEdge* begin, const OuterEdge* end, std::uint32_t centre) {
  std::uint32_t first = begin->a;
  for (const OuterEdge* edge = begin; edge != end; ++edge) {
    if (edge->a == edge->b || edge->has(centre)) return kNoIndex;
    for (const std::uint32_t v : {edge->a, edge->b}) {
      const auto count = std::count_if(begin, end, [v](const OuterEdge& other) { return other.has(v); });
      if (count > 2) return kNoIndex;
      if (count == 1) first = v;
    }
  }
  return first;
}

}  // namespace

VertexStar star_of(std::uint32_t vertex, Span<const Triangle> triangles) {
  VertexStar star{vertex, {}};
  std::fill(std::begin(star.ring), std::end(star.ring), kNoIndex);
  if (triangles.empty() || triangles.size() > kMostTrianglesOfStar) return star;
  OuterEdges edges{};
  OuterEdge* const begin = edges.data();
  OuterEdge* end = std::transform(triangles.begin(), triangles.end(), begin,
                                  [vertex](const Triangle& triangle) { return outer_edge(triangle, vertex); });
  VertexStar found = star;
  found.ring[0] = first_of_ring(begin, end, vertex);
  if (found.ring[0] == kNoIndex) return star;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::uint32_t at = found.ring[i];
    OuterEdge* const next = std::find_if(begin, end, [at](const OuterEdge& edge) { return edge.has(at); });
    if (next == end) return star;
    found.ring[i + 1] = next->a == at ? next->b : next->a;
    *next = *--end;
  }
  return found;
}

}  // namespace softcd
