#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/grid/size_histogram.hpp"
#include "softcd/grid/uniform_grid.hpp"

namespace softcd {

/// Lives in the backend's memory: chosen there, read there.
struct GridParameters {
  float cell_size;
  float inverse_cell_size;
  float mean_radius;
  std::uint32_t active_triangles;
};

/// Loop levels beyond which a triangle is tested against all others instead.
constexpr int kMaxLevel = 6;

/// `exact` leaves triangles whole whose radius is at most this many cells. From 2 to 4, tests of scenes with large
/// triangles rise by less than 1 %; a recorded cloth on a ball has 584 triangles between, whose splitting took 0.18 of
/// 1.13 ms on an H200.
constexpr float kWholeSize = 4.0F;
/// Larger ones are split until their children's radius is at most this many cells.
constexpr float kChildSize = 2.0F;

/// How many tests against other triangles a cell may cost. On one core a cell took 82 ns (marked,
/// registered, sorted) and a test 5 ns: half of that, so that what is in doubt is split.
constexpr float kTestsPerCell = 8.0F;

/// Whole triangles of so few cells across are registered however small the scene is.
constexpr int kFewCellsAcross = 4;

/// Number of 1-to-4 splits after which a triangle of this radius fits a cell of size `limit`; kMaxLevel + 1 when none
/// does.
SOFTCD_HD inline int subdivision_level(float radius, float limit) {
  int level = 0;
  while (level <= kMaxLevel && !(radius <= limit)) {
    radius *= 0.5F;
    ++level;
  }
  return level;
}

/// `exact`: the level that a triangle of this radius is split to, 0 where it stays whole, by the size of a cell less
/// its margin.
SOFTCD_HD inline int split_level(float radius, float limit) {
  return radius <= kWholeSize * limit ? 0 : subdivision_level(radius, kChildSize * limit);
}

/// About how many cells the volume of a triangle takes whose half diagonal, before it was grown by `growth`, is
/// `radius`: what a triangle sweeps fills about an eighth of its box (measured with random directions: 0.08 to 0.13),
/// and the box of radius R is about that of a cube of side 2 R / sqrt(3); a ball's 18-DOP on the grid fills about half
/// of its box.
SOFTCD_HD inline float cell_extent(float radius, float growth) {
  return 0.577F * radius + 1.64F * growth;
}
SOFTCD_HD inline float estimated_cells(float extent, float inverse_cell_size) {
  const float side = extent * inverse_cell_size + 1.0F;
  return side * side * side;
}

/// Values of lambda that stand for 0.
constexpr float kExactLambda = 1.8F;
constexpr float kPaperLambda = 1.2F;

/// Chooses the cell size from the histograms of the active triangles.
///
/// `exact`: lambda times the clipped mean of the margin-inflated radii (measured optimum of what is at rest 1.8, flat
/// from 1.2 to 2.4); `paper`: 3 lambda times that of the swept radii (equation 1); `uniform`, and `paper` without
/// subdivision: 3 largest swept radii. Enlarged where the children of split triangles would outnumber kChildBudget per
/// triangle, where the entries of triangles that move far or have large margins would outnumber a budget per triangle,
/// where the mean triangle moves many cells, and where the grid would not reach the furthest of all but stray
/// triangles.
struct ChooseGrid {
  static constexpr int kChildBudget = 8;
  /// The mean number of entries beyond which larger cells pay: an entry costs as much as 6 (H200) to 11 (16 cores)
  /// tests, and what is in many cells meets the same partners in larger ones. A recorded step of balls has 4.5M entries
  /// and 45M tests at lambda 1.8, 1.0M and 42M with this target: 1.84 and 1.32 ms on an H200.
  static constexpr std::uint64_t kEntryTarget = 5;
  /// With a lambda that was asked for: a bound for memory's sake.
  static constexpr std::uint64_t kEntryBudget = 256;

  const std::uint32_t* radius_bins;
  const std::uint32_t* swept_radius_bins;
  const std::uint32_t* cell_extent_bins;
  const std::uint32_t* distance_bins;  ///< of the largest coordinate magnitude
  BroadPhase broad_phase;
  bool subdivision;
  float lambda;  ///< 0: chosen here
  GridParameters* grid;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    const std::uint64_t active =
        team.sum(kSizeBins, [&](int bin) { return static_cast<std::uint64_t>(radius_bins[bin]); });
    const float mean = clipped_mean(team, broad_phase == BroadPhase::paper ? swept_radius_bins : radius_bins);
    const bool fit_largest = broad_phase == BroadPhase::uniform || (broad_phase == BroadPhase::paper && !subdivision);
    float size = fit_largest                        ? 3.0F * largest_size(team, swept_radius_bins)
                 : broad_phase == BroadPhase::paper ? 3.0F * (lambda > 0.0F ? lambda : kPaperLambda) * mean
                                                    : (lambda > 0.0F ? lambda : kExactLambda) * mean;
    size = larger(size, 8.0F * clipped_mean(team, distance_bins) / kGridReach);
    if (!fit_largest) {
      size = larger(size, clipped_mean(team, swept_radius_bins) / 8.0F);
      if (subdivision) size = within_child_budget(team, size, active);
      size = within_entry_budget(team, size, active);
    }
    // The inverse must be no subnormal number.
    if (!(size > 1.0e-37F)) size = 1.0F;
    if (!(size < 1.0e37F)) size = 1.0e37F;
    if (team.is_leader()) *grid = {size, 1.0F / size, mean, static_cast<std::uint32_t>(active)};
  }

 private:
  template <class Team>
  SOFTCD_HD float within_child_budget(Team& team, float size, std::uint64_t triangles) const {
    for (int enlargement = 0; enlargement < 32; ++enlargement) {
      const std::uint64_t children = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
        const float radius = size_bin_edge(static_cast<std::uint32_t>(bin) + 1U);
        if (radius_bins[bin] == 0) return 0;
        const int level =
            broad_phase == BroadPhase::paper ? subdivision_level(radius, size / 3.0F) : split_level(radius, size);
        return level > 0 && level <= kMaxLevel ? static_cast<std::uint64_t>(radius_bins[bin]) << (2 * level) : 0;
      });
      if (children <= kChildBudget * triangles + 65536) break;
      size *= 1.26F;
    }
    return size;
  }

  /// `exact` tests against all what takes more cells than it is worth: see RegisterTriangle.
  template <class Team>
  SOFTCD_HD float within_entry_budget(Team& team, float size, std::uint64_t triangles) const {
    const bool is_chosen = broad_phase == BroadPhase::exact && !(lambda > 0.0F);
    const std::uint64_t budget = is_chosen ? kEntryTarget * triangles + 4096 : kEntryBudget * triangles + 65536;
    const float most = broad_phase == BroadPhase::exact ? static_cast<float>(triangles) / kTestsPerCell : 1.0e9F;
    for (int enlargement = 0; enlargement < 32; ++enlargement) {
      const std::uint64_t entries = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
        if (cell_extent_bins[bin] == 0) return 0;
        const float cells = estimated_cells(size_bin_edge(static_cast<std::uint32_t>(bin)), 1.0F / size);
        return cell_extent_bins[bin] * static_cast<std::uint64_t>(smaller(cells, most));
      });
      if (entries <= budget) break;
      size *= 1.26F;
    }
    return size;
  }
};

}  // namespace softcd
