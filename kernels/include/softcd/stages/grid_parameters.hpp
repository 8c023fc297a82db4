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

/// `exact` splits triangles until their radius is at most this many cells. From 1 to 2 and to 4, tests of scenes with
/// large triangles rise by 1 to 3 % each time, and the number of children falls to a quarter.
constexpr float kChildSize = 2.0F;

/// How many tests against other triangles a cell of a split one may cost. On one core a cell took 82 ns (marked,
/// registered, sorted) and a test 5 ns: half of that, so that what is in doubt is split.
constexpr float kTestsPerCell = 8.0F;

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

/// Chooses the cell size from the histograms of the active triangles.
///
/// `exact`: lambda times the clipped mean of the margin-inflated radii (measured optimum 1.8, flat from 1.2 to 2.4);
/// `paper`: 3 lambda times that of the swept radii (equation 1); `uniform`, and `paper` without subdivision: 3 largest
/// swept radii. Enlarged where the children of split triangles would outnumber kChildBudget per triangle, where the
/// mean triangle moves many cells or some move so many that entries would outnumber kEntryBudget per triangle, and
/// where the grid would not reach the furthest of all but stray triangles.
struct ChooseGrid {
  static constexpr int kChildBudget = 8;
  static constexpr int kEntryBudget = 256;

  const std::uint32_t* radius_bins;
  const std::uint32_t* swept_radius_bins;
  const std::uint32_t* fast_radius_bins;  ///< swept radii of triangles that move further than they are wide
  const std::uint32_t* distance_bins;     ///< of the largest coordinate magnitude
  BroadPhase broad_phase;
  bool subdivision;
  float lambda;
  GridParameters* grid;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    const std::uint64_t active =
        team.sum(kSizeBins, [&](int bin) { return static_cast<std::uint64_t>(radius_bins[bin]); });
    const float mean = clipped_mean(team, broad_phase == BroadPhase::paper ? swept_radius_bins : radius_bins);
    const bool fit_largest = broad_phase == BroadPhase::uniform || (broad_phase == BroadPhase::paper && !subdivision);
    float size = fit_largest                        ? 3.0F * largest_size(team, swept_radius_bins)
                 : broad_phase == BroadPhase::paper ? 3.0F * lambda * mean
                                                    : lambda * mean;
    size = larger(size, 8.0F * clipped_mean(team, distance_bins) / kGridReach);
    if (!fit_largest) {
      size = larger(size, clipped_mean(team, swept_radius_bins) / 8.0F);
      if (subdivision) size = within_child_budget(team, size, active);
      if (broad_phase == BroadPhase::exact) size = within_entry_budget(team, size, active);
    }
    if (!(size > 1.0e-30F)) size = 1.0F;
    if (!(size < 1.0e30F)) size = 1.0e30F;
    if (team.is_leader()) *grid = {size, 1.0F / size, mean, static_cast<std::uint32_t>(active)};
  }

 private:
  template <class Team>
  SOFTCD_HD float within_child_budget(Team& team, float size, std::uint64_t triangles) const {
    const float limit_per_size = broad_phase == BroadPhase::paper ? 1.0F / 3.0F : kChildSize;
    for (int enlargement = 0; enlargement < 32; ++enlargement) {
      const std::uint64_t children = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
        const float radius = size_bin_edge(static_cast<std::uint32_t>(bin) + 1U);
        if (radius_bins[bin] == 0) return 0;
        const int level = subdivision_level(radius, limit_per_size * size);
        return level > 0 && level <= kMaxLevel ? static_cast<std::uint64_t>(radius_bins[bin]) << (2 * level) : 0;
      });
      if (children <= kChildBudget * triangles + 65536) break;
      size *= 1.26F;
    }
    return size;
  }

  /// A fast triangle's 18-DOP, a prism along its way, fills about an eighth of its box (measured with random
  /// directions: 0.08 to 0.13), and the box of radius R is about that of a cube of side 2 R / sqrt(3).
  template <class Team>
  SOFTCD_HD float within_entry_budget(Team& team, float size, std::uint64_t triangles) const {
    for (int enlargement = 0; enlargement < 32; ++enlargement) {
      const std::uint64_t entries = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
        if (fast_radius_bins[bin] == 0) return 0;
        const float side = 1.1547F * size_bin_edge(static_cast<std::uint32_t>(bin)) / size + 1.0F;
        if (!(side <= static_cast<float>(kMaxSpan))) return 0;
        return fast_radius_bins[bin] * static_cast<std::uint64_t>(0.125F * side * side * side);
      });
      if (entries <= kEntryBudget * triangles + 65536) break;
      size *= 1.26F;
    }
    return size;
  }
};

}  // namespace softcd
