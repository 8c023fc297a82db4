#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "softcd/core/span.hpp"

namespace softcd {

/// Reserves capacity for `count` elements, and at least a quarter more than before, so that slow growth seldom
/// reallocates.
template <class T>
void reserve_roomy(std::vector<T>& values, std::size_t count) {
  if (count > values.capacity()) values.reserve(std::max(count, values.capacity() + values.capacity() / 4));
}

/// A set of indices, in the order of insertion, or in ascending order once sorted. Clearing it takes time for its
/// elements only.
class IndexSet {
 public:
  /// Allows the insertion of indices below `bound`.
  void reserve(std::size_t bound) {
    if (bound <= is_in_.size()) return;
    reserve_roomy(indices_, bound);
    reserve_roomy(is_in_, bound);
    is_in_.resize(bound, 0);
  }
  void insert(std::uint32_t index) noexcept {
    if (is_in_[index] != 0) return;
    is_in_[index] = 1;
    indices_.push_back(index);
  }
  void clear() noexcept {
    for (const std::uint32_t index : indices_) is_in_[index] = 0;
    indices_.clear();
  }
  void sort() noexcept { std::sort(indices_.begin(), indices_.end()); }
  bool contains(std::uint32_t index) const { return is_in_[index] != 0; }
  Span<const std::uint32_t> indices() const { return indices_; }

 private:
  std::vector<std::uint8_t> is_in_;
  std::vector<std::uint32_t> indices_;
};

}  // namespace softcd
