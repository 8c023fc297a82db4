#include "softcd/mesh/closed_surface.hpp"

#include <vector>

namespace softcd {
namespace {

/// A triangle's side: three times the triangle, plus the corner at which it begins.
using Side = std::uint32_t;

/// The sides of each edge: at most one in either direction.
class SidesOfEdges {
 public:
  explicit SidesOfEdges(const MeshView& mesh) : mesh_(mesh), sides_(2 * mesh.edges.size(), kNoIndex) {}

  /// Adds a side. Returns false where one exists already in that direction, or where the side has no length.
  bool add(std::uint32_t triangle, std::uint32_t corner) {
    if (mesh_.triangle_edges[triangle].e[corner] == kNoIndex) return false;
    Side& side = sides_[place(triangle, corner)];
    if (side != kNoIndex) return false;
    side = 3 * triangle + corner;
    return true;
  }

  /// Returns the side that passes through the same edge in the other direction, or kNoIndex.
  Side opposite(std::uint32_t triangle, std::uint32_t corner) const { return sides_[place(triangle, corner) ^ 1U]; }

 private:
  std::size_t place(std::uint32_t triangle, std::uint32_t corner) const {
    const std::uint32_t edge = mesh_.triangle_edges[triangle].e[corner];
    const bool is_forward = mesh_.triangles[triangle].v[corner] == mesh_.edges[edge - mesh_.first_edge].v[0];
    return 2 * static_cast<std::size_t>(edge - mesh_.first_edge) + (is_forward ? 0 : 1);
  }

  const MeshView& mesh_;
  std::vector<Side> sides_;
};

/// Returns the number of triangles around a side's first vertex. All sides must have an opposite.
std::uint32_t count_around(const SidesOfEdges& sides, Side first) {
  std::uint32_t count = 0;
  Side side = first;
  do {
    ++count;
    const Side other = sides.opposite(side / 3, side % 3);
    side = other % 3 == 2 ? other - 2 : other + 1;
  } while (side != first);
  return count;
}

}  // namespace

bool is_closed_surface(const MeshView& mesh) {
  const std::uint32_t triangle_count = mesh.face_count();
  SidesOfEdges sides(mesh);
  std::vector<std::uint32_t> corners(mesh.vertex_count, 0);
  std::vector<Side> first_side(mesh.vertex_count, kNoIndex);
  for (std::uint32_t t = 0; t < triangle_count; ++t) {
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      if (!sides.add(t, corner)) return false;
      const std::uint32_t v = mesh.triangles[t].v[corner] - mesh.first_vertex;
      ++corners[v];
      first_side[v] = 3 * t + corner;
    }
  }
  for (std::uint32_t t = 0; t < triangle_count; ++t) {
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      if (sides.opposite(t, corner) == kNoIndex) return false;
    }
  }
  for (std::uint32_t v = 0; v < mesh.vertex_count; ++v) {
    if (corners[v] > 0 && count_around(sides, first_side[v]) != corners[v]) return false;
  }
  return triangle_count > 0;
}

}  // namespace softcd
