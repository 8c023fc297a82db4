#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/grid/size_histogram.hpp"
#include "softcd/grid/uniform_grid.hpp"

namespace softcd {

/// The grid, which is chosen and read in the backend's memory.
struct GridParameters {
  float cell_size;
  float inverse_cell_size;
  float mean_radius;               ///< of triangles
  std::uint32_t active_triangles;  ///< that take part
  std::uint32_t active_elements;   ///< triangles, or patches instead, that are put into the grid
};

/// Loop levels beyond which a triangle is tested against all others instead.
constexpr int kMaxLevel = 6;

/// Triangles whose radius is at most this many cells stay whole. From 2 to 4, tests of scenes with large triangles rise
/// by less than 1 %. A recorded cloth on a ball has 584 triangles between, whose splitting took 0.18 of 1.13 ms on an
/// H200.
constexpr float kWholeSize = 4.0F;
/// Larger ones are split until their children's radius is at most this many cells.
constexpr float kChildSize = 2.0F;

/// The number of tests against other triangles that a cell may cost. On one core a cell took 82 ns (marked, registered,
/// sorted) and a test 5 ns. This is half of that, so that triangles in doubt are split.
constexpr float kTestsPerCell = 8.0F;

/// Whole triangles of at most this many cells across are registered however small the scene is.
constexpr int kFewCellsAcross = 4;

/// Returns the number of 1-to-4 splits after which a triangle of this radius fits a cell of size `limit`; kMaxLevel + 1
/// if none does.
SOFTCD_HD inline int subdivision_level(float radius, float limit) {
  int level = 0;
  while (level <= kMaxLevel && !(radius <= limit)) {
    radius *= 0.5F;
    ++level;
  }
  return level;
}

/// Returns the level that a triangle of this radius is split to, 0 if it stays whole. `limit` is the size of a cell
/// less its margin.
SOFTCD_HD inline int split_level(float radius, float limit) {
  return radius <= kWholeSize * limit ? 0 : subdivision_level(radius, kChildSize * limit);
}

/// Returns the side of a cube that takes about as many cells as a triangle's volume. `radius` is half the volume's
/// diagonal, before it was grown by `growth`. A swept triangle fills about an eighth of its box (measured with random
/// directions: 0.08 to 0.13). A box of radius R is about a cube of side 2 R / sqrt(3). A ball's 18-DOP on the grid
/// fills about half of its box.
SOFTCD_HD inline float cell_extent(float radius, float growth) {
  return 0.577F * radius + 1.64F * growth;
}
SOFTCD_HD inline float estimated_cells(float extent, float inverse_cell_size) {
  const float side = extent * inverse_cell_size + 1.0F;
  return side * side * side;
}

/// Histograms of the active elements, see MeasureTriangle and MeasurePatch.
struct SizeHistograms {
  const std::uint32_t* radius;
  const std::uint32_t* swept_radius;
  const std::uint32_t* cell_extent;
  const std::uint32_t* distance;         ///< of the largest coordinate magnitude
  const std::uint32_t* triangle_radius;  ///< of triangles; `radius` may be of patches

  SOFTCD_HD bool has(int bin) const {
    return (radius[bin] | swept_radius[bin] | cell_extent[bin] | distance[bin] | triangle_radius[bin]) != 0U;
  }
};

/// Most children of all split triangles, per triangle.
constexpr int kChildBudget = 8;
/// The mean number of entries beyond which larger cells pay. An entry costs as much as 6 (H200) to 11 (16 cores) tests,
/// and triangles in many cells meet the same partners in larger ones. A recorded step of balls has 4.5M entries and 45M
/// tests at cell_size_factor 1.8, 1.0M and 42M with this target: 1.84 and 1.32 ms on an H200.
constexpr std::uint64_t kEntryTarget = 5;
constexpr std::uint64_t kEntryTargetSlack = 4096;
/// Bounds the mean number of entries with a given cell_size_factor, to limit memory alone.
constexpr std::uint64_t kEntryBudget = 256;
constexpr std::uint64_t kEntrySlack = 65536;

template <class Team>
SOFTCD_HD std::uint64_t count_active(Team& team, const std::uint32_t* histogram) {
  return team.sum(kSizeBins, [&](int bin) { return static_cast<std::uint64_t>(histogram[bin]); });
}

/// Returns `size`, or more, so that the grid reaches the furthest of all but stray triangles.
template <class Team>
SOFTCD_HD float within_grid_extent(Team& team, const SizeHistograms& sizes, float size) {
  return larger(size, 8.0F * clipped_mean(team, sizes.distance) / kGridExtent);
}

/// Returns `size`, or more, so that children stay within their budget. `level_of(radius, size)` is the level that a
/// triangle is split to.
template <class Team, class LevelOf>
SOFTCD_HD float within_child_budget(Team& team, const SizeHistograms& sizes, float size, std::uint64_t triangles,
                                    const LevelOf& level_of) {
  for (int enlargement = 0; enlargement < 32; ++enlargement) {
    const std::uint64_t children = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
      if (sizes.radius[bin] == 0) return 0;
      const int level = level_of(size_bin_edge(static_cast<std::uint32_t>(bin) + 1U), size);
      return level > 0 && level <= kMaxLevel ? static_cast<std::uint64_t>(sizes.radius[bin]) << (2 * level) : 0;
    });
    if (children <= kChildBudget * triangles + 65536) break;
    size *= 1.26F;
  }
  return size;
}

/// Returns `size`, or more, so that entries are no more than `budget`. No triangle gets more than `most` of them.
template <class Team>
SOFTCD_HD float within_entry_budget(Team& team, const SizeHistograms& sizes, float size, std::uint64_t budget,
                                    float most) {
  for (int enlargement = 0; enlargement < 32; ++enlargement) {
    const std::uint64_t entries = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
      if (sizes.cell_extent[bin] == 0) return 0;
      const float cells = estimated_cells(size_bin_edge(static_cast<std::uint32_t>(bin)), 1.0F / size);
      return sizes.cell_extent[bin] * static_cast<std::uint64_t>(smaller(cells, most));
    });
    if (entries <= budget) break;
    size *= 1.26F;
  }
  return size;
}

/// Returns a grid with cells of about this size, whose inverse must not be subnormal.
SOFTCD_HD inline GridParameters grid_of_size(float size, float mean_radius, std::uint64_t active_triangles,
                                             std::uint64_t active_elements) {
  if (!(size > 1.0e-37F)) size = 1.0F;
  if (!(size < 1.0e37F)) size = 1.0e37F;
  return {size, 1.0F / size, mean_radius, static_cast<std::uint32_t>(active_triangles),
          static_cast<std::uint32_t>(active_elements)};
}

/// The factor that replaces 0.
constexpr float kExactCellSizeFactor = 1.8F;

/// Chooses the cell size of `exact` and `uniform`.
///
/// `exact`: cell_size_factor times the clipped mean of the margin-inflated radii (measured optimum at rest 1.8, flat
/// from 1.2 to 2.4). `uniform`: 3 largest swept radii. Both enlarge cells if the grid would not reach the furthest of
/// all but stray triangles. `exact` also enlarges them if
/// - the mean triangle moves many cells;
/// - the children of split triangles would exceed a budget per triangle;
/// - the entries of triangles that move far or have large margins would exceed one.
struct ChooseGrid {
  SizeHistograms sizes;
  BroadPhase broad_phase;
  bool subdivision;
  float cell_size_factor;  ///< 0: chosen here
  GridParameters* grid;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    team.skip_zeros(kSizeBins, [&](int bin) { return sizes.has(bin); });
    const std::uint64_t active = count_active(team, sizes.radius);
    const float mean = clipped_mean(team, sizes.radius);
    const bool has_patches = sizes.triangle_radius != sizes.radius;
    const std::uint64_t triangles = has_patches ? count_active(team, sizes.triangle_radius) : active;
    const float triangle_mean = has_patches ? clipped_mean(team, sizes.triangle_radius) : mean;
    const bool fit_largest = broad_phase == BroadPhase::uniform;
    const bool is_chosen = !fit_largest && !(cell_size_factor > 0.0F);
    float size = fit_largest ? 3.0F * largest_size(team, sizes.swept_radius)
                             : (is_chosen ? kExactCellSizeFactor : cell_size_factor) * mean;
    size = within_grid_extent(team, sizes, size);
    if (!fit_largest) {
      size = larger(size, clipped_mean(team, sizes.swept_radius) / 8.0F);
      if (subdivision) {
        const auto level_of = [](float radius, float cell_size) { return split_level(radius, cell_size); };
        size = within_child_budget(team, sizes, size, active, level_of);
      }
      // A triangle that takes more cells than that is tested against all: see RegisterTriangle.
      const float most = static_cast<float>(active) / kTestsPerCell;
      size = within_entry_budget(
          team, sizes, size,
          is_chosen ? kEntryTarget * active + kEntryTargetSlack : kEntryBudget * active + kEntrySlack, most);
    }
    if (team.is_leader()) *grid = grid_of_size(size, triangle_mean, triangles, active);
  }
};

}  // namespace softcd
