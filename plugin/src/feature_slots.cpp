#include "feature_slots.hpp"

#include <numeric>

namespace softcd {

void FeatureSlots::assign(const std::vector<FeatureEnds>& ends, std::uint32_t FeatureEnds::*end,
                          std::size_t slot_count) {
  next_.resize(slot_count);
  std::iota(next_.begin(), next_.end(), 1U);
  if (slot_count > 0) next_.back() = kNoIndex;
  first_.assign(ends.size(), kNoIndex);
  std::uint32_t begin = 0;
  for (std::size_t t = 0; t < ends.size(); ++t) {
    const std::uint32_t of_triangle = ends[t].*end;
    if (of_triangle == begin) continue;
    first_[t] = begin;
    next_[of_triangle - 1] = kNoIndex;
    begin = of_triangle;
  }
  free_ = begin < slot_count ? begin : kNoIndex;
}

bool FeatureSlots::add(const FeaturePart& part, std::uint32_t triangle, std::uint64_t feature) {
  if (free_ == kNoIndex) return false;
  if (triangle >= first_.size()) first_.resize(triangle + std::size_t{1}, kNoIndex);
  const std::uint32_t slot = free_;
  free_ = next_[slot];
  next_[slot] = first_[triangle];
  first_[triangle] = slot;
  put(part, slot, feature);
  return true;
}

}  // namespace softcd
