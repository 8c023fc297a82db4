#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/topology.hpp"
#include "unsent_ranges.hpp"

namespace softcd {

/// A body's part of a list of neighbours' features. Places in it are counted from its first one.
struct FeaturePart {
  Span<std::uint64_t> features;
  std::uint64_t begin;   ///< index in the list
  UnsentRanges& unsent;  ///< of the list
};

/// Locates features within a body's part of a list. Each triangle's features are a chain of slots; a pair of two
/// triangles is in the chain of one of them. Callers that search for a pair must search both chains. Free slots, which
/// hold kNoFeatures, are a chain, too. So capacity runs out only when there are more features than slots.
class FeatureSlots {
 public:
  /// Assigns the first of `slot_count` slots to the triangles, each up to its `end`. The others are free.
  void assign(const std::vector<FeatureEnds>& ends, std::uint32_t FeatureEnds::*end, std::size_t slot_count);
  /// Frees the slots of those features of a triangle for which is_stale(feature) is true.
  template <class IsStale>
  void drop(const FeaturePart& part, std::uint32_t triangle, const IsStale& is_stale);
  /// Adds a feature. Returns false where no slot is free.
  bool add(const FeaturePart& part, std::uint32_t triangle, std::uint64_t feature);

 private:
  void put(const FeaturePart& part, std::uint32_t slot, std::uint64_t feature) {
    part.features[slot] = feature;
    part.unsent.add(part.begin + slot, part.begin + slot + 1);
  }

  std::vector<std::uint32_t> first_;  ///< first slot of each triangle
  std::vector<std::uint32_t> next_;   ///< next slot of the same triangle; for a free slot, the next one to be used
  std::uint32_t free_ = kNoIndex;     ///< the slot that was freed last
};

template <class IsStale>
void FeatureSlots::drop(const FeaturePart& part, std::uint32_t triangle, const IsStale& is_stale) {
  if (triangle >= first_.size()) return;
  for (std::uint32_t* link = &first_[triangle]; *link != kNoIndex;) {
    const std::uint32_t slot = *link;
    if (!is_stale(part.features[slot])) {
      link = &next_[slot];
      continue;
    }
    *link = next_[slot];
    next_[slot] = free_;
    free_ = slot;
    put(part, slot, kNoFeatures);
  }
}

}  // namespace softcd
