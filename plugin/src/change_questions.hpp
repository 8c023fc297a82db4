#pragma once

#include <cstdint>
#include <vector>

#include "softcd/core/spatial_query.hpp"
#include "softcd/stages/mesh_changes.hpp"

namespace softcd::detail {

/// Possible changes of meshes, in the form that detectors take. Owned by ProbeCore.
class ChangesInQuestion {
 public:
  /// Prepares changes of bodies in the scene. Throws InvalidInput, naming the change and the value that is out of
  /// range.
  void prepare(Span<const ProbeChange> changes, Span<const ProbedBody> bodies);

  ChangeQuestions questions() const { return {changes_, removed_, added_, new_vertices_}; }

 private:
  void add(std::size_t index, const ProbeChange& change, Span<const ProbedBody> bodies);

  std::vector<ChangeQuestion> changes_;
  std::vector<std::uint32_t> removed_;
  std::vector<Triangle> added_;
  std::vector<Vec3d> new_vertices_;
};

}  // namespace softcd::detail
