#pragma once

#include <cstdint>

#include "softcd/grid/boxed_entry.hpp"

namespace softcd::cpu {

/// Most partners in a call of partners_to_test().
constexpr std::uint32_t kMostPartners = 64;

namespace generic {
template <bool kSwept>
std::uint64_t partners_to_test(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  std::uint64_t bits = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    const bool boxes_meet = !boxes_certainly_apart<kSwept>(entry, partners[k]);
    const bool is_skipped = (entry.bits & partners[k].bits & ((1U << kMaskBits) - 1U)) != 0U;
    bits |= static_cast<std::uint64_t>(boxes_meet & !is_skipped) << k;
  }
  return bits;
}
}  // namespace generic

/// Return which partners of an entry have to be tested, as far as boxes and masks tell. Bit k is clear if the box of
/// partners[k] is certainly apart from the entry's, and if ExactControl skips the pair. Test several at once, in
/// whatever registers the processor has.
std::uint64_t partners_to_test_swept(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count);
std::uint64_t partners_to_test_at_rest(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count);

template <bool kSwept>
std::uint64_t partners_to_test(const BoxedEntry& entry, const BoxedEntry* partners, std::uint32_t count) {
  return kSwept ? partners_to_test_swept(entry, partners, count) : partners_to_test_at_rest(entry, partners, count);
}

}  // namespace softcd::cpu
