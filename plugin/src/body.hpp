#pragma once

#include <optional>
#include <vector>

#include "softcd/mesh/topology.hpp"
#include "softcd/softcd.hpp"

namespace softcd {

/// A body as the pipeline keeps it.
struct Body {
  BodyId id;
  Topology topology;
  BodySettings settings;
  /// Ownership in force: topology.ownership, or, while vertices are not finite, one that leaves their triangles out.
  std::vector<Ownership> ownership;
  std::vector<std::uint32_t> stray_vertices;  ///< those that are not finite, ascending
  std::uint64_t left_out_triangles = 0;
  /// By the ownership in force; made when the body first has to be tested with itself.
  std::optional<NeighbourFeatures> neighbours;

  /// The caller's positions until a detection has read them, then `kept`; what is read is relative to `offset`.
  bool has_positions = false;
  bool moves = false;  ///< x_t0 is not x_t1
  Positions x_t0, x_t1;
  Vec3d offset{0, 0, 0};
  std::vector<Vec3f> kept_t0, kept_t1;
  double rounding = 0;  ///< most that a kept vertex is from where the caller had it
};

}  // namespace softcd
