#pragma once

#include <cstdint>

#include "softcd/grid/control_bits.hpp"
#include "softcd/math/end_volumes.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/math/simd.hpp"

namespace softcd {

/// A sorted entry and the bounds of its triangle, in two rows of four. Most of its tests read nothing else. Swept, the
/// low halves of words have bounds along x, y and z at t0, and the high halves those at t1. Otherwise the low halves
/// have bounds along x, y and z, and the high halves those along x+y, x+z and y+z. Bounds are counted from the entry's
/// cell in steps, 15 bits each. The top bits of halves are 0 in `lo` and 1 in `hi`.
struct alignas(16) BoxedEntry {
  std::uint32_t lo[3];
  std::uint32_t root;
  std::uint32_t hi[3];
  std::uint32_t bits;

  SOFTCD_HD constexpr Entry entry() const { return {root, bits}; }
};

/// Steps of a box's bounds in a cell: 2^kBoxStepBits.
constexpr int kBoxStepBits = 8;
/// The step of the cell's lower corner, in the middle of the 15 bits: 64 cells to either side. Bounds beyond are at the
/// border.
constexpr int kBoxOrigin = 1 << 14;
constexpr int kLastBoxStep = (1 << 15) - 1;
constexpr std::uint32_t kTopBits = 0x80008000U;

/// The values of a BoxedEntry's halves, in its order: unless swept, t1 stands for a diagonal axis.
using BoxedBounds = EndVolumes::Axis[3];

/// Return the two axes of a diagonal one. Unless swept, the high halves of a BoxedEntry are along diagonal axes.
SOFTCD_HD constexpr int first_of_diagonal(int i) {
  return i == 2 ? 1 : 0;
}
SOFTCD_HD constexpr int second_of_diagonal(int i) {
  return i == 0 ? 1 : 2;
}

namespace generic {
template <bool kSwept, class Control = ExactControl>
SOFTCD_HD BoxedEntry boxed(const BoxedBounds& bounds, std::uint32_t cell, float inverse_cell_size, Entry entry) {
  int steps[3][4];
  int first[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float ends[4] = {bounds[axis].t0_lo, bounds[axis].t1_lo, bounds[axis].t0_hi, bounds[axis].t1_hi};
    for (int i = 0; i < 4; ++i) {
      steps[axis][i] = static_cast<int>(floorf(ends[i] * inverse_cell_size * static_cast<float>(1 << kBoxStepBits)));
    }
    first[axis] = (kSwept ? smaller(steps[axis][0], steps[axis][1]) : steps[axis][0]) >> kBoxStepBits;
  }
  const Cell own = Control::cell_near(cell, {first[0], first[1], first[2]});
  const int cells[3] = {own.x, own.y, own.z};
  BoxedEntry box{{}, entry.root, {}, entry.bits};
  for (int axis = 0; axis < 3; ++axis) {
    const int diagonal_cell = cells[first_of_diagonal(axis)] + cells[second_of_diagonal(axis)];
    const int origins[2] = {cells[axis], kSwept ? cells[axis] : diagonal_cell};
    std::uint32_t halves[4];
    for (int i = 0; i < 4; ++i) {
      const int from_origin = steps[axis][i] - ((origins[i % 2] << kBoxStepBits) - kBoxOrigin);
      halves[i] = static_cast<std::uint32_t>(smaller(larger(from_origin, 0), kLastBoxStep));
    }
    box.lo[axis] = halves[0] | (halves[1] << 16);
    box.hi[axis] = halves[2] | (halves[3] << 16) | kTopBits;
  }
  return box;
}
}  // namespace generic

/// Returns the entry of a triangle in the cell with this index, given its bounds. The triangle is within_grid(). Lower
/// and upper bounds are rounded down alike: a bound that is above another in steps is above it. `Control` knows how
/// cells are numbered.
template <bool kSwept, class Control = ExactControl>
SOFTCD_HD BoxedEntry boxed(const BoxedBounds& bounds, std::uint32_t cell, float inverse_cell_size, Entry entry) {
#ifdef SOFTCD_SSE2
  const __m128 scale = _mm_set1_ps(inverse_cell_size);
  const __m128 steps_of_a_cell = _mm_set1_ps(static_cast<float>(1 << kBoxStepBits));
  // Four values of 32 bits: t0_lo, t0_hi, t1_lo, t1_hi.
  __m128i on_grid[3];
  int firsts[3];
  for (int axis = 0; axis < 3; ++axis) {
    on_grid[axis] = detail::floor_of(_mm_mul_ps(_mm_mul_ps(_mm_load_ps(&bounds[axis].t0_lo), scale), steps_of_a_cell));
    int first = _mm_cvtsi128_si32(on_grid[axis]);
    if (kSwept) first = smaller(first, _mm_cvtsi128_si32(_mm_unpackhi_epi64(on_grid[axis], on_grid[axis])));
    firsts[axis] = first >> kBoxStepBits;
  }
  const Cell own = Control::cell_near(cell, {firsts[0], firsts[1], firsts[2]});
  const int origins[3] = {own.x << kBoxStepBits, own.y << kBoxStepBits, own.z << kBoxStepBits};
  // Steps that 15 bits do not hold are brought to their border.
  const auto steps = [&](int axis) {
    const int low = origins[axis] - kBoxOrigin;
    if (kSwept) return _mm_sub_epi32(on_grid[axis], _mm_set1_epi32(low));
    const int high = origins[first_of_diagonal(axis)] + origins[second_of_diagonal(axis)] - kBoxOrigin;
    return _mm_sub_epi32(on_grid[axis], _mm_setr_epi32(low, low, high, high));
  };
  // Four values of 32 bits: the first axis' lo and hi, then the second one's.
  const auto words = [&](__m128i first, __m128i second) {
    const __m128i halves = _mm_max_epi16(_mm_packs_epi32(first, second), _mm_setzero_si128());
    constexpr int kByBound = _MM_SHUFFLE(3, 1, 2, 0);
    return _mm_or_si128(_mm_shufflehi_epi16(_mm_shufflelo_epi16(halves, kByBound), kByBound),
                        _mm_setr_epi32(0, static_cast<int>(kTopBits), 0, static_cast<int>(kTopBits)));
  };
  const __m128i on_x_and_y = _mm_shuffle_epi32(words(steps(0), steps(1)), _MM_SHUFFLE(3, 1, 2, 0));
  const __m128i on_z = words(steps(2), _mm_setzero_si128());
  BoxedEntry box;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  _mm_storel_epi64(reinterpret_cast<__m128i*>(box.lo), on_x_and_y);
  _mm_storel_epi64(reinterpret_cast<__m128i*>(box.hi), _mm_unpackhi_epi64(on_x_and_y, on_x_and_y));
  box.lo[2] = static_cast<std::uint32_t>(_mm_cvtsi128_si32(on_z));
  box.hi[2] = static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_shuffle_epi32(on_z, 1)));
  box.root = entry.root;
  box.bits = entry.bits;
  return box;
#else
  return generic::boxed<kSwept, Control>(bounds, cell, inverse_cell_size, entry);
#endif
}

/// Whether one lies beyond the other: along x, y or z at both ends of the step (see EndVolumes), or, unless swept,
/// along any axis of their bounds. Both entries are of one cell. Triangles of another cell with the same index share no
/// cell with this one's, so that any result is right for them.
template <bool kSwept>
SOFTCD_HD bool boxes_certainly_apart(const BoxedEntry& a, const BoxedEntry& b) {
  bool is_apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t b_above = (b.hi[axis] - a.lo[axis]) & kTopBits;
    const std::uint32_t a_above = (a.hi[axis] - b.lo[axis]) & kTopBits;
    is_apart |= kSwept ? (b_above == 0U) | (a_above == 0U) : (b_above & a_above) != kTopBits;
  }
  return is_apart;
}

}  // namespace softcd
