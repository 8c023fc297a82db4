#pragma once

#include <vector>

#include "scene_snapshot.hpp"

namespace softcd {

/// Which bodies may touch in this detection, and where.
struct PairSelection {
  std::vector<SceneBody> bodies;
  std::vector<std::uint64_t> partner_begin;  ///< these two: see SceneView
  std::vector<std::uint32_t> partners;
  std::uint64_t pair_count = 0;  ///< of different bodies
  std::uint64_t self_count = 0;
  bool vertex_triangle = false;  ///< some pair wants these features
  bool edge_edge = false;

  SceneBodies view() const { return {bodies, partner_begin, partners}; }
};

/// How far beyond its margin a body's features can be in contact.
struct MarginGrowth {
  float motion = 0.0F;  ///< times the furthest move is added to the margin
  float reach = 1.0F;   ///< times all of that
  /// The margin takes up what rounding has moved positions by, so that nothing that is within it where the caller has
  /// the positions is beyond it where the detector has them.
  bool covers_rounding = false;
};

/// Pairs whose groups, masks, features and grown extents allow a contact and that `filter` lets through. Extents are
/// relative to `origin`, as positions are, which write_positions has rounded.
PairSelection select_pairs(const std::vector<Body>& bodies, const std::vector<BodySurvey>& surveys, Vec3d origin,
                           const MarginGrowth& growth, const PairFilter& filter);

}  // namespace softcd
