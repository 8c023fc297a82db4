#include "lanes/partners.hpp"

#include "lanes/targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lanes/partners.cpp"  // NOLINT(readability-identifier-naming): Highway wants it
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once for each kind of processor, in a namespace of its own.
HWY_BEFORE_NAMESPACE();
namespace softcd::cpu::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

template <bool kSwept>
std::uint64_t partners_in_lanes(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  return generic::partners_to_test<kSwept>(entry, partners, count);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

/// An entry takes two lanes: an even one has values of its lower row, the next one values of its upper row.
using Rows = hn::ScalableTag<std::uint32_t>;
using Entries = hn::ScalableTag<std::uint64_t>;
using Words = hn::Vec<Rows>;

/// Values of the tested entry that are the same for all of its partners.
struct Tester {
  Words is_lower;  ///< all bits set in lower rows
  Words minuend[3];
  Words mask;

  HWY_INLINE explicit Tester(const BoxedEntry& entry) {
    const Rows rows;
    const Words none = hn::Zero(rows);
    is_lower = hn::OddEven(none, hn::Set(rows, ~0U));
    // ~x + 1 is -x: with partners' lower rows inverted this gives hi - partner.lo and partner.hi - lo.
    for (int axis = 0; axis < 3; ++axis) {
      minuend[axis] = hn::OddEven(hn::Set(rows, 0U - entry.lo[axis]), hn::Set(rows, entry.hi[axis] + 1U));
    }
    mask = hn::OddEven(hn::Set(rows, entry.bits & ((1U << kMaskBits) - 1U)), none);
  }
};

/// Sets the top bit where the one ends above where the other begins; see generic::boxes_certainly_apart.
template <bool kSwept>
HWY_INLINE Words meets(const Tester& tester, int axis, Words partners) {
  const Words difference = hn::Add(hn::Xor(partners, tester.is_lower), tester.minuend[axis]);
  const Words low_half = hn::ShiftLeft<16>(difference);
  return kSwept ? hn::Or(difference, low_half) : hn::And(difference, low_half);
}

/// Returns bits of as many partners as registers hold.
template <bool kSwept>
HWY_INLINE std::uint64_t register_of_partners(const Tester& tester, const BoxedEntry* partners) {
  const Rows rows;
  const Entries entries;
  Words x, y, z, others;
  hn::LoadInterleaved4(rows, partners->lo, x, y, z, others);
  const Words boxes_meet =
      hn::And(hn::And(meets<kSwept>(tester, 0, x), meets<kSwept>(tester, 1, y)), meets<kSwept>(tester, 2, z));
  const auto is_not_skipped = hn::Eq(hn::And(others, tester.mask), hn::Zero(rows));
  const auto both_rows = hn::BitCast(entries, hn::And(boxes_meet, hn::VecFromMask(rows, is_not_skipped)));
  const auto top_bits = hn::Set(entries, 0x8000000080000000U);
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(entries, hn::Eq(hn::And(both_rows, top_bits), top_bits), bits);
  return bits[0];
}

template <bool kSwept>
std::uint64_t partners_in_lanes(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  const auto at_once = static_cast<std::uint32_t>(hn::Lanes(Entries()));
  if (count < at_once) return generic::partners_to_test<kSwept>(entry, partners, count);
  const Tester tester(entry);
  std::uint64_t bits = 0;
  std::uint32_t k = 0;
  for (; k + at_once <= count; k += at_once) bits |= register_of_partners<kSwept>(tester, partners + k) << k;
  // The last register also holds some that were tested before.
  k = count - at_once;
  return bits | (register_of_partners<kSwept>(tester, partners + k) << k);
}

#endif

std::uint64_t swept(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  return partners_in_lanes<true>(entry, partners, count);
}
std::uint64_t at_rest(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  return partners_in_lanes<false>(entry, partners, count);
}

}  // namespace softcd::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace softcd::cpu {

HWY_EXPORT(swept);
HWY_EXPORT(at_rest);

std::uint64_t partners_to_test_swept(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  return HWY_DYNAMIC_DISPATCH(swept)(entry, partners, count);
}
std::uint64_t partners_to_test_at_rest(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  return HWY_DYNAMIC_DISPATCH(at_rest)(entry, partners, count);
}

}  // namespace softcd::cpu
#endif
