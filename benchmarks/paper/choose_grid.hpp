#pragma once

#include <cstdint>

#include "softcd/stages/grid_parameters.hpp"

namespace softcd::paper {

/// The factor where the options have 0, which lets the detector choose.
constexpr float kCellSizeFactor = 1.2F;

/// Chooses cells of 3 times `cell_size_factor` (the paper's lambda, equation 1) mean swept radii. Without subdivision,
/// cells are 3 largest radii wide. Enlarges them as softcd::ChooseGrid does, with a bound on entries that only limits
/// memory.
struct ChooseGrid {
  SizeHistograms sizes;
  bool subdivision;
  float cell_size_factor;  ///< 0: chosen here
  GridParameters* grid;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    const std::uint64_t active = count_active(team, sizes.radius);
    const float mean = clipped_mean(team, sizes.swept_radius);
    float size = subdivision ? 3.0F * (cell_size_factor > 0.0F ? cell_size_factor : kCellSizeFactor) * mean
                             : 3.0F * largest_size(team, sizes.swept_radius);
    size = within_grid_extent(team, sizes, size);
    if (subdivision) {
      const auto level = [](float radius, float cell_size) { return subdivision_level(radius, cell_size / 3.0F); };
      size = within_child_budget(team, sizes, size, active, level);
      size = within_entry_budget(team, sizes, size, kEntryBudget * active + kEntrySlack, 1.0e9F);
    }
    if (team.is_leader()) *grid = grid_of_size(size, mean, active, active);
  }
};

}  // namespace softcd::paper
