#pragma once

#include <cstdint>

#include "softcd/grid/control_bits.hpp"

namespace softcd::paper {

/// The control bits as printed (Le Grand 2007; the paper, section 3.3), on the parity type of cells, type = x&1 | y&1
/// << 1 | z&1 << 2. They are, with the number of bits:
/// - the home type of the representing child: 3;
/// - the types of the cells that it touches: 8;
/// - the types of its siblings' home cells: 8.
///
/// Deferring to siblings follows the order of types, as deferring to home cells does. The text uses child ids instead,
/// but then the two orders contradict each other and lose a tenth of the pairs. Even so, the bits lose true pairs and
/// repeat others, so that every pair is flagged.
struct Control {
  /// Cells are numbered z:9 | y:9 | x:9, so the number's bits give the parity of each coordinate.
  static constexpr int kAxisBits = 9;
  static constexpr int kAxisMask = (1 << kAxisBits) - 1;

  static SOFTCD_HD constexpr std::uint32_t cell_index(Cell cell) {
    return (static_cast<std::uint32_t>(cell.z & kAxisMask) << (2 * kAxisBits)) |
           (static_cast<std::uint32_t>(cell.y & kAxisMask) << kAxisBits) |
           static_cast<std::uint32_t>(cell.x & kAxisMask);
  }

  /// Returns the cell with this number that is at most 128 before `near` along each axis, or fewer than 384 after it.
  static SOFTCD_HD constexpr Cell cell_near(std::uint32_t index, Cell near) {
    const auto unwrapped = [index](int axis, int first) {
      const auto coordinate = static_cast<int>(index >> (axis * kAxisBits));
      return first + (((coordinate - first + 128) & kAxisMask) - 128);
    };
    return {unwrapped(0, near.x), unwrapped(1, near.y), unwrapped(2, near.z)};
  }

  static SOFTCD_HD constexpr std::uint32_t pack(std::uint32_t home_type, std::uint32_t touched,
                                                std::uint32_t siblings) {
    return home_type | (touched << 3) | (siblings << 11);
  }

  static SOFTCD_HD constexpr std::uint32_t type_of(std::uint32_t cell) {
    return (cell & 1U) | (((cell >> kAxisBits) & 1U) << 1) | (((cell >> (2 * kAxisBits)) & 1U) << 2);
  }

  static SOFTCD_HD constexpr Verdict judge(std::uint32_t cell, Entry a, Entry b) {
    const std::uint32_t type = type_of(cell);
    const std::uint32_t home_a = a.bits & 7U;
    const std::uint32_t home_b = b.bits & 7U;
    if (home_a != type && home_b != type) return Verdict::skip;
    const std::uint32_t touched_a = (a.bits >> 3) & 255U;
    const std::uint32_t touched_b = (b.bits >> 3) & 255U;
    if (home_a < type && ((touched_b >> home_a) & 1U) != 0U) return Verdict::skip;
    if (home_b < type && ((touched_a >> home_b) & 1U) != 0U) return Verdict::skip;
    const std::uint32_t siblings_a = (a.bits >> 11) & 255U;
    const std::uint32_t siblings_b = (b.bits >> 11) & 255U;
    const std::uint32_t lower_types = (1U << type) - 1U;
    if ((((siblings_a & touched_b) | (siblings_b & touched_a)) & lower_types) != 0U) return Verdict::skip;
    return Verdict::execute_and_flag;
  }

  /// Entries of a cell have one rank: each is compared with all before it.
  static SOFTCD_HD constexpr std::uint32_t lowest_partner_k(std::uint32_t /*k*/) { return 0; }
};

}  // namespace softcd::paper
