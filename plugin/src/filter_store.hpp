#pragma once

#include <utility>
#include <vector>

#include "scene_layout.hpp"

namespace softcd {

/// Returns rest positions as floats relative to the middle of their box. All must be finite.
std::vector<Vec3f> rest_positions(const Positions& x);

/// The data of bodies' feature filters for detectors, for all vertices of the scene. A filter that no body has stays
/// empty. Owned by SceneStore.
class FilterStore {
 public:
  /// Records that a body's filters or settings have changed.
  void note_change() { ++revision_; }
  /// Brings the arrays up to date if a filter or a mesh has changed.
  void update(const SceneLayout& layout);
  FilterArrays arrays() const { return {vertices_, ring_begin_, ring_vertices_, x_rest_}; }

  /// Returns whether the arrays have changed since the last forget_changes().
  bool are_unsent() const { return are_unsent_; }
  void forget_changes() { are_unsent_ = false; }

 private:
  void list_rings(const SceneLayout& layout);

  std::uint64_t revision_ = 1;
  std::pair<std::uint64_t, std::uint64_t> updated_{0, 0};  ///< revisions of this object and of the layout
  std::vector<VertexFilter> vertices_;
  std::vector<std::uint64_t> ring_begin_;
  std::vector<std::uint32_t> ring_vertices_;
  std::vector<Vec3f> x_rest_;
  bool are_unsent_ = false;
};

}  // namespace softcd
