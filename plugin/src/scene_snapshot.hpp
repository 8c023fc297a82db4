#pragma once

#include <array>
#include <vector>

#include "body.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// All bodies' connectivity, concatenated in ascending order of ids.
struct SceneArrays {
  std::vector<Triangle> triangles, triangle_edges;
  std::vector<Edge> edges;
  std::vector<Ownership> ownership;
  std::vector<std::uint32_t> triangle_body, vertex_body;
  std::vector<std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;

  SceneTopology topology() const {
    return {
        triangles,           triangle_edges, edges, ownership, triangle_body, vertex_body, vertex_triangle_neighbours,
        edge_edge_neighbours};
  }
};

/// Whether a body is to be tested with itself and has no neighbours listed.
bool lacks_neighbours(const std::vector<Body>& bodies);
/// Lists the neighbours of those bodies. The scene has to be concatenated anew then.
void list_neighbours(std::vector<Body>& bodies);

SceneArrays concatenate(const std::vector<Body>& bodies);

/// Extent of a body over the part of the step that counts.
struct BodyExtent {
  bool is_empty = true;  ///< no positions, or none that is finite
  Vec3d lo{}, hi{};
  double furthest_move = 0;  ///< largest distance between a vertex's two ends
};

/// A body's extent and its vertices that are not finite, or too large for float32.
struct BodySurvey {
  BodyExtent extent;
  bool moves = false;  ///< some vertex is not at t1 where it was at t0; false where t0 does not count
  std::vector<std::uint32_t> stray_vertices;
  double rounding = 0;  ///< furthest that write_positions has moved a vertex
};

/// Reads what positions were set since the last time; the bodies do not refer to the caller's memory afterwards, even
/// when it throws. `both_ends` takes t0 into the extents and fills `moves` (CCD), `measure_moves` fills furthest_move.
std::vector<BodySurvey> survey_bodies(std::vector<Body>& bodies, bool both_ends, bool measure_moves);

/// The point that is subtracted from all positions, in double, before they become float32. An axis is shifted only
/// where the scene is at least as far from the origin as it is wide: the difference of two numbers within a factor of
/// two of each other is exact (Sterbenz 1974), so that float32 positions stay as they are, shifted or not.
Vec3d scene_origin(const std::vector<BodySurvey>& surveys);

/// Writes all positions relative to `origin`, t0 only where `write_t0`. Bodies without positions and stray vertices
/// become 0. Fills the surveys' `rounding`.
void write_positions(const std::vector<Body>& bodies, Vec3d origin, bool write_t0, PositionArrays out,
                     std::vector<BodySurvey>& surveys);

}  // namespace softcd
