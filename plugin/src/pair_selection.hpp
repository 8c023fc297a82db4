#pragma once

#include <vector>

#include "scene_snapshot.hpp"

namespace softcd {

/// Which bodies may touch in this detection, and where.
struct PairSelection {
  std::vector<SceneBody> bodies;
  std::vector<std::uint32_t> may_touch;  ///< see SceneView
  std::uint32_t pair_words = 0;
  std::uint64_t pair_count = 0;  ///< of different bodies
  std::uint64_t self_count = 0;
  bool vertex_triangle = false;  ///< some pair wants these features
  bool edge_edge = false;

  SceneBodies view() const { return {bodies, may_touch, pair_words}; }
};

/// Pairs whose groups, masks, features and grown extents allow a contact and that `filter` lets through. Extents are
/// relative to `origin`.
PairSelection select_pairs(const std::vector<Body>& bodies, const std::vector<BodySurvey>& surveys, Vec3d origin,
                           float motion_margin, const PairFilter& filter);

}  // namespace softcd
