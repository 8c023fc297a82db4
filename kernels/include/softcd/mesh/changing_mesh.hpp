#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "softcd/mesh/index_set.hpp"
#include "softcd/mesh/topology.hpp"

namespace softcd {

/// A mesh in which some triangles change at a time. A change costs time for these triangles and those around them only.
/// Its topology is that of build_topology, except for the edges' order. Remaining edges keep their indices, and new
/// edges take free indices or follow behind the last.
class ChangingMesh {
 public:
  explicit ChangingMesh(Topology mesh);

  /// Returns the topology. An edge {0, 0} belongs to no triangle: its index is free.
  const Topology& topology() const { return mesh_; }
  /// Returns the number of edges that belong to a triangle.
  std::uint32_t edge_count() const { return static_cast<std::uint32_t>(mesh_.edges.size() - free_edges_.size()); }
  bool lists_neighbours() const { return has_few_corners_around(corners_around_, mesh_.triangles.size()); }
  /// Calls visit(t) for every triangle t of the vertex, once, in any order.
  template <class Visit>
  void for_each_triangle_of(std::uint32_t v, Visit visit) const {
    for (std::uint32_t corner = first_corner_[v]; corner != kNoIndex; corner = links_[corner].next) visit(corner / 3);
  }

  /// Changes the mesh to `triangles`. Reads those with indices in `changed`, and those behind the mesh's last; keeps
  /// the others. Indices must be below vertex_count, also in kept triangles. Changes nothing when it throws
  /// std::bad_alloc.
  void change(Span<const Triangle> triangles, std::uint32_t vertex_count, Span<const std::uint32_t> changed);

  /// Return what has changed since the last forget_changes(): triangles with other vertices, edges or ownership, and
  /// edges with other vertices. Some may no longer exist.
  Span<const std::uint32_t> changed_triangles() const { return changed_triangles_.indices(); }
  Span<const std::uint32_t> changed_edges() const { return changed_edges_.indices(); }
  bool has_changes() const { return has_changes_; }
  void forget_changes() noexcept;

  /// Returns the triangles with other vertices, edges or ownership since the last forget_relisted(). The first
  /// forget_relisted() turns this bookkeeping on. NeighbourFeatures must be listed again for these triangles and their
  /// neighbours. Some may no longer exist.
  Span<const std::uint32_t> relisted_triangles() const { return relisted_.indices(); }
  bool is_relisted(std::uint32_t t) const { return relisted_.contains(t); }
  /// Returns those triangles and the neighbours that they had.
  Span<const std::uint32_t> stale_triangles() const { return stale_.indices(); }
  /// Return whether a listed pair (vertex and triangle, or two edges) must be listed again, or no longer exists. For
  /// such a pair, the triangle and the vertex's owner, or both edges' owners, are among stale_triangles().
  bool is_stale_pair(std::uint32_t vertex, std::uint32_t triangle) const {
    return relisted_.contains(triangle) || stale_vertices_.contains(vertex);
  }
  bool are_stale_edges(std::uint32_t a, std::uint32_t b) const {
    return stale_edges_.contains(a) || stale_edges_.contains(b);
  }
  void forget_relisted() noexcept;

 private:
  /// Links of a triangle's corner, 3 * triangle + corner, to other corners at the same vertex. Of a triangle's corners
  /// at one vertex, only the first is linked.
  struct Links {
    std::uint32_t previous, next;
  };
  struct KeyedEdge {
    std::uint64_t key;
    std::uint32_t edge;
  };

  void reserve(std::size_t triangle_count, std::size_t vertex_count, std::size_t touched_count);
  void take_out(std::uint32_t triangle) noexcept;
  void put_in(std::uint32_t triangle, const Triangle& vertices) noexcept;
  void link(std::uint32_t corner) noexcept;
  void unlink(std::uint32_t corner) noexcept;
  void mark_changing(std::uint32_t triangle) noexcept;
  void mark_stale(std::uint32_t triangle) noexcept;
  std::uint32_t edge_between(std::uint32_t a, std::uint32_t b) noexcept;
  void find_lost_edges() noexcept;
  void give_vertex(std::uint32_t vertex) noexcept;
  void give_edge(std::uint32_t edge) noexcept;
  template <class OwnershipIn>
  std::uint32_t give(std::uint32_t vertex, const OwnershipIn& ownership_in) noexcept;

  Topology mesh_;
  std::vector<Links> links_;
  std::vector<std::uint32_t> first_corner_;    ///< of each vertex
  std::vector<std::uint32_t> triangle_count_;  ///< of each vertex
  std::uint64_t corners_around_ = 0;           ///< the sum of the squares of triangle_count_
  std::vector<std::uint32_t> free_edges_;
  IndexSet changed_triangles_, changed_edges_;
  IndexSet relisted_, stale_;              ///< triangles
  IndexSet stale_vertices_, stale_edges_;  ///< owned by relisted triangles when the features were listed
  bool has_changes_ = false, finds_relisted_ = false;
  // State of the change in progress:
  IndexSet touched_;                    ///< triangles that it removes, adds, or both
  IndexSet vertices_, edges_;           ///< of these triangles, before and after
  std::vector<KeyedEdge> lost_by_key_;  ///< edges of removed triangles, by their vertices
};

}  // namespace softcd
