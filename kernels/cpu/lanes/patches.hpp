#pragma once

#include <bit>
#include <cstdint>

#include "../work_units.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/stages/patches.hpp"

namespace softcd::cpu {

/// The bounds of an element along x, y and z; at rest, the same at both ends.
struct StraightBounds {
  EndVolumes::Axis axes[3];
};

namespace generic {
template <bool kSwept>
std::uint32_t rows_that_meet(const PatchBounds<kSwept>& a, const StraightBounds& b) {
  constexpr int kLast = PatchBounds<kSwept>::kEnds - 1;
  std::uint32_t rows = 0;
  for (std::uint32_t row = 0; row < kPatchSize; ++row) {
    bool is_apart = false;
    for (int axis = 0; axis < 3; ++axis) {
      const EndVolumes::Axis on_b = b.axes[axis];
      is_apart |= (a.hi[axis][0][row] < on_b.t0_lo) & (a.hi[axis][kLast][row] < on_b.t1_lo);
      is_apart |= (on_b.t0_hi < a.lo[axis][0][row]) & (on_b.t1_hi < a.lo[axis][kLast][row]);
    }
    rows |= (is_apart ? 0U : 1U) << row;
  }
  return rows;
}

template <bool kSwept>
std::uint64_t triangles_that_meet(const PatchBounds<kSwept>& a, std::uint32_t rows, const PatchBounds<kSwept>& b,
                                  bool leaves_neighbours) {
  std::uint64_t bits = 0;
  for (; rows != 0; rows &= rows - 1U) {
    const auto row = static_cast<std::uint32_t>(lowest_bit(rows));
    const std::uint32_t owners = b.owners_with(a, row);
    for (std::uint32_t column = 0; column < kPatchSize; ++column) {
      bool is_apart = (owners >> column & 1U) == 0U;
      for (int axis = 0; axis < kKdopAxes; ++axis) {
        bool is_below = true;
        bool is_above = true;
        for (int end = 0; end < PatchBounds<kSwept>::kEnds; ++end) {
          is_below &= a.hi[axis][end][row] < b.lo[axis][end][column];
          is_above &= b.hi[axis][end][column] < a.lo[axis][end][row];
        }
        is_apart |= is_below | is_above;
      }
      const Triangle in_row = {{a.v[0][row], a.v[1][row], a.v[2][row]}};
      const Triangle in_column = {{b.v[0][column], b.v[1][column], b.v[2][column]}};
      is_apart |= leaves_neighbours && share_vertex(in_row, in_column);
      bits |= std::uint64_t{is_apart ? 0U : 1U} << (kPatchSize * row + column);
    }
  }
  return bits;
}

/// Returns the ends of a patch's triangle along x, y and z.
inline EndVolumes straight_ends_of(const PatchBounds<true>& patch, std::uint32_t i) {
  EndVolumes ends{};
  for (int axis = 0; axis < 3; ++axis) {
    ends.axes[axis] = {patch.lo[axis][0][i], patch.hi[axis][0][i], patch.lo[axis][1][i], patch.hi[axis][1][i]};
  }
  return ends;
}

inline std::uint64_t triangles_that_move_past(const PatchBounds<true>& a, std::uint64_t meeting,
                                              const PatchBounds<true>& b) {
  std::uint64_t bits = 0;
  for (std::uint64_t left = meeting; left != 0; left &= left - 1) {
    const auto part = static_cast<std::uint32_t>(std::countr_zero(left));
    const bool is_past = move_past(straight_ends_of(a, part / kPatchSize), straight_ends_of(b, part % kPatchSize));
    bits |= std::uint64_t{is_past ? 1U : 0U} << part;
  }
  return bits;
}
}  // namespace generic

/// Return which triangles of a patch meet an element's box: bits of `rows`. A bit is clear only if they are apart along
/// x, y or z, in one direction at both ends of the step. Test several at once, in whatever registers the processor has.
std::uint32_t rows_that_meet(const PatchBounds<true>& a, const StraightBounds& b);
std::uint32_t rows_that_meet(const PatchBounds<false>& a, const StraightBounds& b);

/// Return which triangles of two patches meet. Bit kPatchSize * r + c is about triangle r of `a` and triangle c of `b`.
/// It is set only if r is in `rows`, which are bits. Else it is clear only if
/// - their volumes are apart along an axis, in one direction at both ends of the step;
/// - or neither owns a feature that could touch the other;
/// - or they share a vertex, and such neighbours are left out.
/// Test several columns at once, in whatever registers the processor has.
std::uint64_t triangles_that_meet(const PatchBounds<true>& a, std::uint32_t rows, const PatchBounds<true>& b,
                                  bool leaves_neighbours);
std::uint64_t triangles_that_meet(const PatchBounds<false>& a, std::uint32_t rows, const PatchBounds<false>& b,
                                  bool leaves_neighbours);

/// Returns those of the pairs in `meeting`, bits as triangles_that_meet() has them, of which one moves past the other:
/// see move_past(). Tests several columns at once, in whatever registers the processor has.
std::uint64_t triangles_that_move_past(const PatchBounds<true>& a, std::uint64_t meeting, const PatchBounds<true>& b);

template <bool kSwept>
struct UnitLanes<ExpandPatchPair<kSwept>> {
  using F = ExpandPatchPair<kSwept>;
  static constexpr bool kDecides = true;

  /// Called for all parts of an item.
  static std::uint64_t may_pass(const F& f, const PatchWork& work, std::uint32_t /*begin*/, std::uint32_t /*count*/) {
    static_assert(kPatchSize * kPatchSize <= kUnitsAtOnce);
    const PatchBounds<kSwept>& b = f.bounds_of(work.b);
    if (!work.has_two_patches) {
      PatchBounds<kSwept> a;  // NOLINT(cppcoreguidelines-pro-type-member-init): one row is read
      f.load_first(work.a, a);
      return on_their_way(f, work, a, triangles_that_meet(a, 1U, b, work.leaves_neighbours), b);
    }
    const PatchBounds<kSwept>& a = f.bounds_of(work.a);
    const StraightBounds box = {{f.bounds_on(0, work.b), f.bounds_on(1, work.b), f.bounds_on(2, work.b)}};
    const std::uint64_t meet = triangles_that_meet(a, rows_that_meet(a, box), b, work.leaves_neighbours);
    return on_their_way(f, work, a, work.a == work.b ? meet & kAboveDiagonal : meet, b);
  }

 private:
  /// Returns the pairs of `meeting` but for those of which one moves past the other without meeting it.
  static std::uint64_t on_their_way(const F& f, const PatchWork& work, const PatchBounds<kSwept>& a,
                                    std::uint64_t meeting, const PatchBounds<kSwept>& b) {
    if constexpr (kSwept) {
      if (meeting == 0 || f.may_share_vertex(work)) return meeting;
      for (std::uint64_t left = triangles_that_move_past(a, meeting, b); left != 0; left &= left - 1) {
        MeetingTriangles pair;  // NOLINT(cppcoreguidelines-pro-type-member-init): list() sets it
        f.list(work, static_cast<std::uint32_t>(std::countr_zero(left)), pair);
        if (!f.pair_test.meet_in_a_slab(pair.a, pair.b)) meeting &= ~(left & -left);
      }
    }
    return meeting;
  }

  /// The columns behind the row in each row, so that a patch and itself have each pair once.
  static constexpr std::uint64_t kAboveDiagonal = [] {
    std::uint64_t bits = 0;
    for (std::uint32_t row = 0; row < kPatchSize; ++row) {
      const std::uint32_t columns = (1U << kPatchSize) - (2U << row);
      bits |= static_cast<std::uint64_t>(columns) << (kPatchSize * row);
    }
    return bits;
  }();
};

template <bool kSwept>
struct UnitLanes<KeepPatchPair<kSwept>> : UnitLanes<ExpandPatchPair<false>> {};

}  // namespace softcd::cpu
