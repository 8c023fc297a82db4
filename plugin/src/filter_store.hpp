#pragma once

#include <utility>
#include <vector>

#include "scene_layout.hpp"

namespace softcd {

/// As floats relative to the middle of their box. All are finite.
std::vector<Vec3f> rest_positions(const Positions& x);

/// What detectors need to know of bodies' feature filters, for all vertices of the scene; nothing of a kind that no
/// body has.
class FilterStore {
 public:
  /// A body's filters, or its settings, have changed.
  void note_change() { ++revision_; }
  /// Brings the arrays up to date if a filter or a mesh has changed.
  void update(const SceneLayout& layout);
  FilterArrays arrays() const { return {vertices_, ring_begin_, ring_vertices_, x_rest_}; }

  /// Since the last forget_changes().
  bool are_unsent() const { return are_unsent_; }
  void forget_changes() { are_unsent_ = false; }

 private:
  void list_rings(const SceneLayout& layout);

  std::uint64_t revision_ = 1;
  std::pair<std::uint64_t, std::uint64_t> updated_{0, 0};  ///< this revision, and the layout's
  std::vector<VertexFilter> vertices_;
  std::vector<std::uint64_t> ring_begin_;
  std::vector<std::uint32_t> ring_vertices_;
  std::vector<Vec3f> x_rest_;
  bool are_unsent_ = false;
};

}  // namespace softcd
