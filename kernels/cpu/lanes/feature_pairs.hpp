#pragma once

#include "../work_units.hpp"
#include "features.hpp"
#include "softcd/stages/feature_filters.hpp"
#include "softcd/stages/feature_pairs.hpp"

namespace softcd::cpu {

template <class F>
struct FeatureLanes {
  static std::uint64_t keep(const F& f, const FeatureCandidate* candidates, std::uint32_t count) {
    static_assert(kCandidatesAtOnce <= kMostCandidates);
    return candidates_to_keep(f.feature_test, candidates, count);
  }
};

template <ContactKind kKind, bool kSwept>
struct CandidateLanes<ExpandPair<kKind, kSwept>> : FeatureLanes<ExpandPair<kKind, kSwept>> {};
template <ContactKind kKind, bool kSwept>
struct CandidateLanes<TestNeighbours<kKind, kSwept>> : FeatureLanes<TestNeighbours<kKind, kSwept>> {};
template <class Find>
struct CandidateLanes<WithFilters<Find>> : FeatureLanes<WithFilters<Find>> {};

}  // namespace softcd::cpu
