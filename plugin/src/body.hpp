#pragma once

#include <optional>
#include <vector>

#include "body_positions.hpp"
#include "softcd/mesh/topology.hpp"
#include "softcd/softcd.hpp"

namespace softcd {

/// What of a body takes part in a detection: all of it, but for the triangles with a vertex that is not finite.
struct Participation {
  std::vector<Ownership> ownership;
  std::vector<std::uint32_t> stray_vertices;  ///< those that are not finite, ascending
  std::uint64_t left_out_triangles = 0;
  /// By this ownership; made when the body first has to be tested with itself.
  std::optional<NeighbourFeatures> neighbours;
};

/// A body as the pipeline keeps it.
struct Body {
  BodyId id;
  bool is_removed = false;  ///< only its place is left
  Topology topology;
  BodySettings settings;
  Participation participation;
  BodyPositions positions;
};

Body make_body(BodyId id, const BodyDesc& desc);

/// Triangles with a stray vertex own nothing and take no part; their other vertices and edges pass to neighbours.
Participation participation_without(const std::vector<std::uint32_t>& stray_vertices, const Topology& topology);

}  // namespace softcd
