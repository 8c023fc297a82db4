#pragma once

#include <cstdint>
#include <vector>

#include "body.hpp"
#include "box_pairs.hpp"
#include "softcd/fields/options.hpp"

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
  bool is_rounded = false;   ///< some body, where that is to be covered
  std::uint64_t number = 0;  ///< of the selector's

  SceneBodies view() const { return {bodies, partner_begin, partners, number}; }
};

/// What a detection takes of bodies.
struct Selecting {
  bool t0 = false, t1 = false;  ///< these ends' extents
  /// The ends of which positions are computed with, where what rounding has moved them by is to be covered.
  bool covers_rounding_t0 = false, covers_rounding_t1 = false;
  bool margins = true;
  bool neighbour_filters = true;
  float motion_margin = 0.0F;    ///< times the furthest move is added to the margin
  float distance_factor = 1.0F;  ///< times all of that
  Features features;
  std::uint64_t changed_since = 0;  ///< a body of each pair, see Body::last_change
};

template <>
inline constexpr auto kFields<Selecting> =
    fields_of<Selecting, &Selecting::t0, &Selecting::t1, &Selecting::covers_rounding_t0, &Selecting::covers_rounding_t1,
              &Selecting::margins, &Selecting::neighbour_filters, &Selecting::motion_margin,
              &Selecting::distance_factor, &Selecting::features, &Selecting::changed_since>();

inline bool operator==(const Selecting& a, const Selecting& b) {
  return has_equal_fields(a, b);
}

/// Chooses pairs for one detection after another. Memory, and what is known of where bodies are, serves the next.
class PairSelector {
 public:
  /// Pairs whose groups, masks, features and grown extents allow a contact and that `filter` lets through. Extents are
  /// relative to `origin`, as positions are. Valid until the next call. Without a filter those of the last call are
  /// selected again where all is the same but for what bodies have the same `bodies_number`, which is not 0.
  const PairSelection& select(const std::vector<Body>& bodies, Vec3d origin, const Selecting& selecting,
                              const PairFilter& filter, std::uint64_t bodies_number = 0);

 private:
  void survey_bodies(const std::vector<Body>& bodies, Vec3d origin, const Selecting& selecting);
  void write_rows();

  PairSelection selection_;
  Selecting selected_by_;
  std::uint64_t selected_of_ = 0;       ///< the number of bodies, where they had one, and there was no filter
  std::vector<Box> boxes_;              ///< of all bodies, empty where they are nowhere
  std::vector<std::uint32_t> batches_;  ///< empty where there is one
  BoxPairs box_pairs_;
  std::vector<IndexPair> pairs_;  ///< that were chosen, ascending
  std::vector<std::uint64_t> row_ends_;
};

}  // namespace softcd
