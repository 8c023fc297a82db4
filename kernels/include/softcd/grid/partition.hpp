#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/core/host_device.hpp"
#include "softcd/grid/uniform_grid.hpp"

namespace softcd {

/// Cells, by their wrapped indices; see cell_index.
constexpr std::uint32_t kCellCount = 1U << (3 * kCellBits);

/// Which part of a detection one of several ranks does, all of which have the whole scene and choose the same grid.
/// Control bits let each pair of triangles be tested in one cell, so that it is tested by the rank that has this cell.
/// What is not found in cells is shared out by numbers.
struct Partition {
  Share rank{0, 1};
  /// The rank's cells: first_cell <= index < end_cell. Together all ranks have all cells, in the order of ranks.
  std::uint32_t first_cell = 0;
  std::uint32_t end_cell = kCellCount;

  friend bool operator==(const Partition&, const Partition&) = default;

  SOFTCD_HD constexpr bool is_whole() const { return rank.count == 1; }
  SOFTCD_HD constexpr bool has(std::uint32_t cell) const { return first_cell <= cell && cell < end_cell; }
  /// Whether cells between these layers, lo and hi included, may be the rank's. Layers are contiguous indices.
  SOFTCD_HD constexpr bool has_layers(int lo, int hi) const {
    for (int z = lo; z <= hi; ++z) {
      const std::uint32_t first = cell_index(Cell{0, 0, z});
      if (first < end_cell && first_cell < first + (1U << (2 * kCellBits))) return true;
    }
    return false;
  }
};

/// See TestSamples.
constexpr int kTestSamples = 64;

}  // namespace softcd
