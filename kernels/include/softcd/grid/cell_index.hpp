#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

/// Numbers of cells: 27 bits for a grid without borders. Cells share a number where their difference is in a lattice of
/// index 2^27.
///
/// The lattice has no short vector, so that triangles which share a cell meet nowhere else. It has no vector near an
/// axis, and only long ones in the planes of two axes. So a road, a river or a wide sheet does not meet itself.
namespace softcd {

/// A cell's integer coordinates: cell i covers [i s, (i + 1) s) on each axis, s the cell size.
struct Cell {
  int x, y, z;
};

constexpr int kCellBits = 27;
constexpr std::uint32_t kCellCount = 1U << kCellBits;
constexpr std::uint32_t kCellMask = kCellCount - 1U;

/// The steps of numbers along y and z. Rows of up to 5967 cells, and layers of up to 47 rows, have ascending numbers;
/// along each axis 2^27 cells have numbers of their own.
constexpr std::uint32_t kCellRow = 5967;
constexpr std::uint32_t kCellLayer = 285923;

/// Most cells that the cells of a triangle span along each axis.
constexpr int kMaxSpan = 128;

/// Returns the cell's number.
SOFTCD_HD constexpr std::uint32_t cell_index(Cell cell) {
  return (static_cast<std::uint32_t>(cell.x) + kCellRow * static_cast<std::uint32_t>(cell.y) +
          kCellLayer * static_cast<std::uint32_t>(cell.z)) &
         kCellMask;
}

/// Returns the number of the cell with number `cell`, moved from the origin to the cell with number `offset`.
SOFTCD_HD constexpr std::uint32_t moved_cell(std::uint32_t cell, std::uint32_t offset) {
  return (cell + offset) & kCellMask;
}
/// Returns the opposite of `offset`.
SOFTCD_HD constexpr std::uint32_t opposite_cell(std::uint32_t offset) {
  return (0U - offset) & kCellMask;
}

namespace detail {

/// A vector of a short basis of the lattice, found by a search over kCellRow and kCellLayer. A function, since device
/// code reads no arrays of the host's.
SOFTCD_HD constexpr Cell lattice_vector(int i) {
  return i == 0 ? Cell{-8, -68, -468} : i == 1 ? Cell{493, -48, 1} : Cell{-51, -575, 12};
}

/// Returns the cross product of the other two vectors, in cyclic order. Divided by 2^27 it gives coordinate `i` of a
/// cell.
SOFTCD_HD constexpr Cell dual_vector(int i) {
  const Cell a = lattice_vector((i + 1) % 3);
  const Cell b = lattice_vector((i + 2) % 3);
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

constexpr int magnitude_of(int x) {
  return x < 0 ? -x : x;
}

/// Whether all cells up to kMaxSpan from the origin have coordinates below one half along vector `i`.
constexpr bool fits_window(int i) {
  const Cell dual = dual_vector(i);
  const int sum = magnitude_of(dual.x) + magnitude_of(dual.y) + magnitude_of(dual.z);
  return 2LL * kMaxSpan * sum < static_cast<long long>(kCellCount);
}

static_assert(lattice_vector(0).x * dual_vector(0).x + lattice_vector(0).y * dual_vector(0).y +
                  lattice_vector(0).z * dual_vector(0).z ==
              static_cast<int>(kCellCount));
static_assert(cell_index(lattice_vector(0)) == 0 && cell_index(lattice_vector(1)) == 0 &&
              cell_index(lattice_vector(2)) == 0);
static_assert(fits_window(0) && fits_window(1) && fits_window(2));

}  // namespace detail

/// Returns the cell with this number that is at most kMaxSpan from `nearby` along each axis, if there is one.
SOFTCD_HD constexpr Cell cell_near(std::uint32_t index, Cell nearby) {
  constexpr std::int64_t kHalf = kCellCount / 2;
  // Away from `nearby`: `along` cells along x, but for a vector of the lattice.
  const auto along = static_cast<std::int64_t>((index - cell_index(nearby) + kCellCount / 2) & kCellMask) - kHalf;
  Cell away = {static_cast<int>(along), 0, 0};
  for (int i = 0; i < 3; ++i) {
    const auto times = static_cast<int>((along * detail::dual_vector(i).x + kHalf) >> kCellBits);
    away.x -= times * detail::lattice_vector(i).x;
    away.y -= times * detail::lattice_vector(i).y;
    away.z -= times * detail::lattice_vector(i).z;
  }
  return {nearby.x + away.x, nearby.y + away.y, nearby.z + away.z};
}

}  // namespace softcd
