#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "body.hpp"
#include "body_pair_list.hpp"

namespace softcd {

/// As floats relative to the middle of their box. All are finite.
std::vector<Vec3f> rest_positions(const Positions& x);

/// What detectors need to know of bodies' feature filters, for all vertices of the scene; nothing of a kind that no
/// body has.
class FilterStore {
 public:
  /// A body's filters, or its settings, have changed.
  void note_change() { ++revision_; }
  /// Brings the arrays up to date, where something or, as `mesh_revision` says, a mesh has changed. `mesh_of` tells
  /// where a body's mesh is.
  void settle(const std::vector<Body>& bodies, std::size_t vertex_count, std::uint64_t mesh_revision,
              const std::function<MeshView(const Body&)>& mesh_of);
  FilterArrays arrays() const { return {vertices_, ring_begin_, ring_vertices_, x_rest_}; }

  /// Since the last forget_changes().
  bool are_unsent() const { return are_unsent_; }
  void forget_changes() { are_unsent_ = false; }

 private:
  void list_rings(const std::vector<Body>& bodies, std::size_t vertex_count,
                  const std::function<MeshView(const Body&)>& mesh_of);

  std::uint64_t revision_ = 1;
  std::pair<std::uint64_t, std::uint64_t> settled_{0, 0};  ///< this revision, and the mesh's
  std::vector<VertexFilter> vertices_;
  std::vector<std::uint64_t> ring_begin_;
  std::vector<std::uint32_t> ring_vertices_;
  std::vector<Vec3f> x_rest_;
  bool are_unsent_ = false;
};

}  // namespace softcd
