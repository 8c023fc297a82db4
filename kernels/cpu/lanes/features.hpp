#pragma once

#include <bit>
#include <cstdint>

#include "softcd/stages/feature_pairs.hpp"

namespace softcd::cpu {

/// Most candidates in a call of candidates_to_keep().
constexpr std::uint32_t kMostCandidates = 64;

namespace generic {
template <ContactKind kKind, bool kSwept>
std::uint64_t candidates_to_keep(const FeatureTest<kKind, kSwept>& test, const FeatureCandidate* candidates,
                                 std::uint32_t count) {
  std::uint64_t bits = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool is_kept = test.filter(candidates[i]) && test.keeps(candidates[i]);
    bits |= static_cast<std::uint64_t>(is_kept) << i;
  }
  return bits;
}
}  // namespace generic

/// Returns the candidates that the test keeps among those with these bits, which pass the filter.
template <class Test>
std::uint64_t kept_one_by_one(const Test& test, const FeatureCandidate* candidates, std::uint64_t bits) {
  for (std::uint64_t left = bits; left != 0; left &= left - 1) {
    if (!test.keeps(candidates[std::countr_zero(left)])) bits &= ~(left & -left);
  }
  return bits;
}

/// Returns which candidates the test keeps, bit i for candidates[i]. Tests several at once, in whatever registers the
/// processor has.
template <ContactKind kKind, bool kSwept>
std::uint64_t candidates_to_keep(const FeatureTest<kKind, kSwept>& test, const FeatureCandidate* candidates,
                                 std::uint32_t count);

}  // namespace softcd::cpu
