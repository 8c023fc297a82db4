#include "lanes/patches.hpp"

#include "lanes/targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lanes/patches.cpp"  // NOLINT(readability-identifier-naming): Highway wants it
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/vectors-inl.hpp"

// Compiled once for each kind of processor, in a namespace of its own.
HWY_BEFORE_NAMESPACE();
namespace softcd::cpu::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

template <bool kSwept>
std::uint64_t meet_in_lanes(const PatchBounds<kSwept>& a, std::uint32_t rows, const PatchBounds<kSwept>& b,
                            bool leaves_neighbours) {
  return generic::triangles_that_meet<kSwept>(a, rows, b, leaves_neighbours);
}

template <bool kSwept>
std::uint32_t rows_in_lanes(const PatchBounds<kSwept>& a, const StraightBounds& b) {
  return generic::rows_that_meet<kSwept>(a, b);
}

std::uint64_t past_in_lanes(const PatchBounds<true>& a, std::uint64_t meeting, const PatchBounds<true>& b) {
  return generic::triangles_that_move_past(a, meeting, b);
}

#else

using Columns = hn::CappedTag<float, kPatchSize>;

HWY_INLINE std::uint32_t mask_bits(hn::Mask<Columns> mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(Columns(), mask, bits);
  return bits[0];
}

/// Returns which of a register's columns, from `first` on, lie beyond the row along the axis, at all ends of the step.
template <bool kSwept>
HWY_INLINE hn::Mask<Columns> apart_on(const PatchBounds<kSwept>& a, std::uint32_t row, const PatchBounds<kSwept>& b,
                                      std::size_t first, int axis) {
  const Columns columns;
  const auto below = [&](int end) HWY_ATTR {
    return hn::Lt(hn::Set(columns, a.hi[axis][end][row]), hn::LoadU(columns, b.lo[axis][end] + first));
  };
  const auto above = [&](int end) HWY_ATTR {
    return hn::Lt(hn::LoadU(columns, b.hi[axis][end] + first), hn::Set(columns, a.lo[axis][end][row]));
  };
  if constexpr (kSwept) {
    return hn::Or(hn::And(below(0), below(1)), hn::And(above(0), above(1)));
  } else {
    return hn::Or(below(0), above(0));
  }
}

template <bool kSwept>
HWY_INLINE hn::Mask<Columns> share_vertex_in_lanes(const PatchBounds<kSwept>& a, std::uint32_t row,
                                                   const PatchBounds<kSwept>& b, std::size_t first) {
  const hn::RebindToUnsigned<Columns> words;
  const auto has = [&](int corner) HWY_ATTR {
    const auto of_column = hn::LoadU(words, b.v[corner] + first);
    return hn::Or(
        hn::Or(hn::Eq(of_column, hn::Set(words, a.v[0][row])), hn::Eq(of_column, hn::Set(words, a.v[1][row]))),
        hn::Eq(of_column, hn::Set(words, a.v[2][row])));
  };
  return hn::RebindMask(Columns(), hn::Or(hn::Or(has(0), has(1)), has(2)));
}

template <bool kSwept>
HWY_INLINE std::uint64_t columns_in_lanes(const PatchBounds<kSwept>& a, std::uint32_t row, const PatchBounds<kSwept>& b,
                                          bool leaves_neighbours) {
  const Columns columns;
  const std::size_t at_once = hn::Lanes(columns);
  std::uint64_t bits = 0;
  for (std::size_t first = 0; first < kPatchSize; first += at_once) {
    auto apart = apart_on<kSwept>(a, row, b, first, 0);
    for (int axis = 1; axis < 3; ++axis) apart = hn::Or(apart, apart_on<kSwept>(a, row, b, first, axis));
    if (hn::AllTrue(columns, apart)) continue;
    for (int axis = 3; axis < kKdopAxes; ++axis) apart = hn::Or(apart, apart_on<kSwept>(a, row, b, first, axis));
    if (leaves_neighbours) apart = hn::Or(apart, share_vertex_in_lanes<kSwept>(a, row, b, first));
    bits |= static_cast<std::uint64_t>(~mask_bits(apart) & ((1U << at_once) - 1U)) << first;
  }
  return bits & b.owners_with(a, row);
}

template <bool kSwept>
std::uint64_t meet_in_lanes(const PatchBounds<kSwept>& a, std::uint32_t rows, const PatchBounds<kSwept>& b,
                            bool leaves_neighbours) {
  std::uint64_t bits = 0;
  for (; rows != 0; rows &= rows - 1U) {
    const auto row = static_cast<std::uint32_t>(lowest_bit(rows));
    bits |= columns_in_lanes<kSwept>(a, row, b, leaves_neighbours) << (kPatchSize * row);
  }
  return bits;
}

/// Returns which of a register's rows, from `first` on, lie beyond the box along the axis, at all ends of the step.
template <bool kSwept>
HWY_INLINE hn::Mask<Columns> rows_apart_on(const PatchBounds<kSwept>& a, std::size_t first, EndVolumes::Axis on_b,
                                           int axis) {
  const Columns rows;
  const auto below = [&](int end, float lo)
                         HWY_ATTR { return hn::Lt(hn::LoadU(rows, a.hi[axis][end] + first), hn::Set(rows, lo)); };
  const auto above = [&](int end, float hi)
                         HWY_ATTR { return hn::Lt(hn::Set(rows, hi), hn::LoadU(rows, a.lo[axis][end] + first)); };
  if constexpr (kSwept) {
    return hn::Or(hn::And(below(0, on_b.t0_lo), below(1, on_b.t1_lo)),
                  hn::And(above(0, on_b.t0_hi), above(1, on_b.t1_hi)));
  } else {
    return hn::Or(below(0, on_b.t0_lo), above(0, on_b.t0_hi));
  }
}

template <bool kSwept>
std::uint32_t rows_in_lanes(const PatchBounds<kSwept>& a, const StraightBounds& b) {
  const Columns columns;
  const std::size_t at_once = hn::Lanes(columns);
  std::uint32_t bits = 0;
  for (std::size_t first = 0; first < kPatchSize; first += at_once) {
    auto apart = rows_apart_on<kSwept>(a, first, b.axes[0], 0);
    for (int axis = 1; axis < 3; ++axis) apart = hn::Or(apart, rows_apart_on<kSwept>(a, first, b.axes[axis], axis));
    bits |= (~mask_bits(apart) & ((1U << at_once) - 1U)) << first;
  }
  return bits;
}

using OfColumns = hn::Vec<Columns>;

/// How far a register's columns, from `first` on, move along an axis, twice, and how wide they are at the end.
struct MotionOnAxis {
  OfColumns motion, width;
};

HWY_INLINE MotionOnAxis motion_on(const PatchBounds<true>& patch, std::size_t first, int axis) {
  const Columns columns;
  const OfColumns t1_lo = hn::LoadU(columns, patch.lo[axis][1] + first);
  const OfColumns t1_hi = hn::LoadU(columns, patch.hi[axis][1] + first);
  const OfColumns t0_lo = hn::LoadU(columns, patch.lo[axis][0] + first);
  const OfColumns t0_hi = hn::LoadU(columns, patch.hi[axis][0] + first);
  return {hn::Sub(hn::Add(t1_lo, t1_hi), hn::Add(t0_lo, t0_hi)), hn::Sub(t1_hi, t1_lo)};
}

/// Does the same as move_past() for a row and some columns, whose motion is known.
HWY_INLINE hn::Mask<Columns> move_past_row(const PatchBounds<true>& a, std::uint32_t row, const MotionOnAxis (&b)[3]) {
  const Columns columns;
  OfColumns motion = hn::Zero(columns);
  OfColumns width = hn::Zero(columns);
  for (int axis = 0; axis < 3; ++axis) {
    const float t1_lo = a.lo[axis][1][row];
    const float t1_hi = a.hi[axis][1][row];
    const float motion_a = (t1_lo + t1_hi) - (a.lo[axis][0][row] + a.hi[axis][0][row]);
    const OfColumns relative = hn::Sub(hn::Set(columns, motion_a), b[axis].motion);
    motion = larger(motion, hn::Mul(hn::Set(columns, 0.5F), hn::Abs(relative)));
    width = larger(width, hn::Add(hn::Set(columns, t1_hi - t1_lo), b[axis].width));
  }
  return hn::Gt(motion, width);
}

std::uint64_t past_in_lanes(const PatchBounds<true>& a, std::uint64_t meeting, const PatchBounds<true>& b) {
  const std::size_t at_once = hn::Lanes(Columns());
  std::uint64_t bits = 0;
  for (std::size_t first = 0; first < kPatchSize; first += at_once) {
    const MotionOnAxis motions[3] = {motion_on(b, first, 0), motion_on(b, first, 1), motion_on(b, first, 2)};
    for (std::uint32_t row = 0; row < kPatchSize; ++row) {
      const std::size_t part = kPatchSize * row + first;
      if ((meeting >> part & ((1U << at_once) - 1U)) == 0U) continue;
      bits |= static_cast<std::uint64_t>(mask_bits(move_past_row(a, row, motions))) << part;
    }
  }
  return bits & meeting;
}

#endif

std::uint64_t meet_swept(const PatchBounds<true>& a, std::uint32_t rows, const PatchBounds<true>& b,
                         bool leaves_neighbours) {
  return meet_in_lanes<true>(a, rows, b, leaves_neighbours);
}
std::uint64_t meet_at_rest(const PatchBounds<false>& a, std::uint32_t rows, const PatchBounds<false>& b,
                           bool leaves_neighbours) {
  return meet_in_lanes<false>(a, rows, b, leaves_neighbours);
}
std::uint32_t rows_swept(const PatchBounds<true>& a, const StraightBounds& b) {
  return rows_in_lanes<true>(a, b);
}
std::uint32_t rows_at_rest(const PatchBounds<false>& a, const StraightBounds& b) {
  return rows_in_lanes<false>(a, b);
}
std::uint64_t past(const PatchBounds<true>& a, std::uint64_t meeting, const PatchBounds<true>& b) {
  return past_in_lanes(a, meeting, b);
}

}  // namespace softcd::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace softcd::cpu {

HWY_EXPORT(meet_swept);
HWY_EXPORT(meet_at_rest);
HWY_EXPORT(rows_swept);
HWY_EXPORT(rows_at_rest);
HWY_EXPORT(past);

std::uint64_t triangles_that_meet(const PatchBounds<true>& a, std::uint32_t rows, const PatchBounds<true>& b,
                                  bool leaves_neighbours) {
  return HWY_DYNAMIC_DISPATCH(meet_swept)(a, rows, b, leaves_neighbours);
}
std::uint64_t triangles_that_meet(const PatchBounds<false>& a, std::uint32_t rows, const PatchBounds<false>& b,
                                  bool leaves_neighbours) {
  return HWY_DYNAMIC_DISPATCH(meet_at_rest)(a, rows, b, leaves_neighbours);
}
std::uint32_t rows_that_meet(const PatchBounds<true>& a, const StraightBounds& b) {
  return HWY_DYNAMIC_DISPATCH(rows_swept)(a, b);
}
std::uint32_t rows_that_meet(const PatchBounds<false>& a, const StraightBounds& b) {
  return HWY_DYNAMIC_DISPATCH(rows_at_rest)(a, b);
}
std::uint64_t triangles_that_move_past(const PatchBounds<true>& a, std::uint64_t meeting, const PatchBounds<true>& b) {
  return HWY_DYNAMIC_DISPATCH(past)(a, meeting, b);
}

}  // namespace softcd::cpu
#endif
