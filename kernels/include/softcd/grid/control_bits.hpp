#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/grid/uniform_grid.hpp"

namespace softcd {

/// Exact control bits. Let S be the set of cells that a triangle is registered in. Its entry in cell c carries a mask
/// of which of c's 13 lexicographically lower neighbours, ordered by (z, y, x), are in S as well. A pair is tested in c
/// iff the two masks have no common bit.
///
/// Complete: the lexicographically lowest cell common to both sets has no lower common neighbour, so it always passes.
/// Once: if both sets are integer DOPs, or one fits into 2 x 2 x 2 cells, every other common cell has a lower common
/// neighbour. Between DOPs it is a step towards the lowest cell, by the signs of the difference. The step changes none
/// of the nine forms by more than their total difference, so it stays inside both. Other pairs, of split triangles, are
/// flagged and made unique.
///
/// Mask bits: dz = -1: bit 3 (dy + 1) + (dx + 1), bits 0 to 8;  dz = 0, dy = -1: bit 9 + dx + 1;  dz = dy = 0, dx = -1:
/// bit 12.
constexpr std::uint32_t kMaskBits = 13;

/// A row (fixed y and z) of an integer DOP, and the four rows that hold its cells' lower neighbours.
struct CellRow {
  CellInterval cells;
  CellInterval below[4];  ///< (y - 1, z - 1), (y, z - 1), (y + 1, z - 1), (y - 1, z)

  SOFTCD_HD constexpr CellRow(const IntegerDop& volume, int y, int z)
      : cells(volume.row(y, z)),
        below{volume.row(y - 1, z - 1), volume.row(y, z - 1), volume.row(y + 1, z - 1), volume.row(y - 1, z)} {}

  /// Returns the mask of cell x.
  SOFTCD_HD constexpr std::uint32_t mask(int x) const {
    std::uint32_t bits = cells.contains(x - 1) ? 1U << 12 : 0U;
    for (int r = 0; r < 4; ++r) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (below[r].contains(x + dx)) bits |= 1U << (3 * r + dx + 1);
      }
    }
    return bits;
  }
};

/// K: bit a is set when the lower face neighbour along axis a is NOT in S. A face neighbour common to both entries of a
/// pair is a common mask bit. So the pair can pass the mask test only if K_a | K_b == 7.
SOFTCD_HD constexpr std::uint32_t missing_face_neighbours(std::uint32_t mask) {
  return ((~mask >> 12) & 1U) | (((~mask >> 10) & 1U) << 1) | (((~mask >> 4) & 1U) << 2);
}

/// An entry's sort key, 30 bits: cell:27 | rank:3. The entries of a cell are ordered by rank, so that those which an
/// entry may have to be tested with lie together.
SOFTCD_HD constexpr std::uint32_t entry_key(std::uint32_t cell, std::uint32_t rank) {
  return (cell << 3) | rank;
}
SOFTCD_HD constexpr std::uint32_t key_cell(std::uint32_t key) {
  return key >> 3;
}
SOFTCD_HD constexpr std::uint32_t key_rank(std::uint32_t key) {
  return key & 7U;
}

/// An entry's data besides its key, 64 bits: root:32 | control:19 | body class:5 | owned features:6 | spare:2 from low
/// to high. In ExactControl, `control` is a 13-bit mask | split:1 | fits 2x2x2:1.
struct alignas(8) Entry {
  std::uint32_t root;
  std::uint32_t bits;
};

constexpr std::uint32_t kBodyClasses = 32;

/// `owned`: the owned features of wanted kinds, bits as in Ownership.
SOFTCD_HD constexpr std::uint32_t entry_bits(std::uint32_t control, std::uint32_t body, std::uint32_t owned) {
  return control | ((body % kBodyClasses) << 19) | ((owned & 63U) << 24);
}
SOFTCD_HD constexpr std::uint32_t body_class(Entry e) {
  return (e.bits >> 19) & (kBodyClasses - 1U);
}
SOFTCD_HD constexpr std::uint32_t owned_vertices(Entry e) {
  return (e.bits >> 24) & 7U;
}
SOFTCD_HD constexpr std::uint32_t owned_edges(Entry e) {
  return (e.bits >> 27) & 7U;
}

/// The outcome for a pair in a cell.
enum class Verdict : std::uint32_t { skip, execute, execute_and_flag };

struct ExactControl {
  static SOFTCD_HD constexpr std::uint32_t pack(std::uint32_t mask, bool split, bool fits) {
    return mask | (split ? 1U << 13 : 0U) | (fits ? 1U << 14 : 0U);
  }

  static SOFTCD_HD constexpr Verdict judge(std::uint32_t /*cell*/, Entry a, Entry b) {
    const std::uint32_t either = a.bits | b.bits;
    const bool may_repeat = ((either >> 13) & 3U) == 1U;
    const Verdict verdict = may_repeat ? Verdict::execute_and_flag : Verdict::execute;
    return (a.bits & b.bits & ((1U << kMaskBits) - 1U)) != 0U ? Verdict::skip : verdict;
  }

  static SOFTCD_HD constexpr Cell cell_near(std::uint32_t index, Cell nearby) {
    return softcd::cell_near(index, nearby);
  }

  /// Within a cell sorted by descending K, entry j can only meet entries before it with K_i >= 7 ^ K_j.
  static SOFTCD_HD constexpr std::uint32_t lowest_partner_k(std::uint32_t k) { return 7U ^ k; }
};

}  // namespace softcd
