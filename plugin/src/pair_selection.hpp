#pragma once

#include <cstdint>
#include <vector>

#include "body.hpp"
#include "box_pairs.hpp"
#include "softcd/fields/options.hpp"

namespace softcd {

/// The bodies that may touch in a detection, and the pairs of them.
struct PairSelection {
  std::vector<SceneBody> bodies;
  std::vector<std::uint64_t> partner_begin;  ///< see SceneView, also for the next member
  std::vector<std::uint32_t> partners;
  std::uint64_t pair_count = 0;  ///< pairs of different bodies
  std::uint64_t self_count = 0;
  bool vertex_triangle = false;  ///< some pair is tested for these features
  bool edge_edge = false;
  bool is_rounded = false;   ///< the detection compensates rounding, and some body was rounded
  std::uint64_t number = 0;  ///< the selector's number for this selection

  SceneBodies view() const { return {bodies, partner_begin, partners, number}; }
};

/// The data of bodies that a detection uses.
struct Selecting {
  bool t0 = false, t1 = false;  ///< whether the extents at these ends count
  /// The ends whose positions are used for arithmetic, where their rounding must be compensated.
  bool covers_rounding_t0 = false, covers_rounding_t1 = false;
  bool margins = true;
  bool neighbour_filters = true;
  float motion_margin = 0.0F;    ///< margins grow by this factor times the longest path of a vertex
  float distance_factor = 1.0F;  ///< then distances grow by this factor
  Features features;
  std::uint64_t changed_since = 0;  ///< selects only pairs with a body that changed later, see Body::last_change
};

template <>
inline constexpr auto kFields<Selecting> =
    fields_of<Selecting, &Selecting::t0, &Selecting::t1, &Selecting::covers_rounding_t0, &Selecting::covers_rounding_t1,
              &Selecting::margins, &Selecting::neighbour_filters, &Selecting::motion_margin,
              &Selecting::distance_factor, &Selecting::features, &Selecting::changed_since>();

inline bool operator==(const Selecting& a, const Selecting& b) {
  return has_equal_fields(a, b);
}

/// Selects pairs for one detection after another. Reuses memory and boxes of the previous call. Each query has one,
/// which SceneCore calls before the detector.
class PairSelector {
 public:
  /// Returns pairs whose groups, masks, features and enlarged extents allow a contact, and that `filter` admits.
  /// Extents are relative to `origin`, as positions are. Valid until the next call.
  ///
  /// Without a filter, returns the last selection again if everything is the same. Bodies count as the same if they
  /// have the same `bodies_number`, unless that is 0.
  const PairSelection& select(const std::vector<Body>& bodies, Vec3d origin, const Selecting& selecting,
                              const PairFilter& filter, std::uint64_t bodies_number = 0);

 private:
  void survey_bodies(const std::vector<Body>& bodies, Vec3d origin, const Selecting& selecting);
  void write_rows();

  PairSelection selection_;
  Selecting selected_by_;
  std::uint64_t selected_of_ = 0;       ///< bodies_number of the selection, if it had one and no filter
  std::vector<Box> boxes_;              ///< of all bodies; empty where a body has no extent
  std::vector<std::uint32_t> batches_;  ///< empty where there is only one batch
  BoxPairs box_pairs_;
  std::vector<IndexPair> pairs_;  ///< selected pairs, ascending
  std::vector<std::uint64_t> row_ends_;
};

}  // namespace softcd
