#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/core/host_device.hpp"
#include "softcd/grid/cell_index.hpp"

namespace softcd {

/// The part of a detection that one of several ranks does. All ranks have the whole scene and choose the same grid.
/// Control bits let each pair of triangles be tested in one cell, and the rank that has this cell tests it. Work
/// outside of cells is divided by numbers.
struct Partition {
  Share rank{0, 1};
  /// The rank's cells: first_cell <= index < end_cell. Together all ranks have all cells, in the order of ranks.
  std::uint32_t first_cell = 0;
  std::uint32_t end_cell = kCellCount;

  friend bool operator==(const Partition&, const Partition&) = default;

  SOFTCD_HD constexpr bool is_whole() const { return rank.count == 1; }
  SOFTCD_HD constexpr bool has(std::uint32_t cell) const { return first_cell <= cell && cell < end_cell; }
  /// Whether cells between these corners, both included, may be the rank's, once moved by `offset`.
  SOFTCD_HD constexpr bool may_have(Cell lo, Cell hi, std::uint32_t offset) const {
    for (int z = lo.z; z <= hi.z; ++z) {
      const std::uint32_t first = moved_cell(cell_index({lo.x, lo.y, z}), offset);
      const std::uint32_t last = first + cell_index({hi.x - lo.x, hi.y - lo.y, 0});
      if (first < end_cell && first_cell <= last) return true;
      if (last >= kCellCount && first_cell <= last - kCellCount) return true;  // numbers begin again
    }
    return false;
  }
};

/// See TestSamples.
constexpr int kTestSamples = 64;

}  // namespace softcd
