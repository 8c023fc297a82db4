#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/topology.hpp"
#include "unsent_ranges.hpp"

namespace softcd {

/// A body's part of a list of neighbours' features. Places in it are counted from its first.
struct FeaturePart {
  Span<std::uint64_t> features;
  std::uint64_t begin;   ///< in the list
  UnsentRanges& unsent;  ///< of the list
};

/// Where features of a body's part of a list are. Those of two triangles, of which either one will be asked, are with
/// one of the two: each triangle's are a chain of slots, and so are those that are free, which hold kNoFeatures. So
/// room runs out where there are more features than slots, and not before.
class FeatureSlots {
 public:
  /// Of so many slots the first hold each triangle's up to its `end`, and the others are free.
  void assign(const std::vector<FeatureEnds>& ends, std::uint32_t FeatureEnds::*end, std::size_t slot_count);
  /// Frees the slots of a triangle's features of which is_stale(feature).
  template <class IsStale>
  void drop(const FeaturePart& part, std::uint32_t triangle, const IsStale& is_stale);
  /// False where there is no slot.
  bool add(const FeaturePart& part, std::uint32_t triangle, std::uint64_t feature);

 private:
  void put(const FeaturePart& part, std::uint32_t slot, std::uint64_t feature) {
    part.features[slot] = feature;
    part.unsent.add(part.begin + slot, part.begin + slot + 1);
  }

  std::vector<std::uint32_t> first_;  ///< each triangle's slot
  std::vector<std::uint32_t> next_;   ///< slot of the same triangle; of free ones the next that is taken
  std::uint32_t free_ = kNoIndex;     ///< the last one that became free
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
