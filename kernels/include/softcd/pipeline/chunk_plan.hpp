#pragma once

#include <algorithm>
#include <cstdint>
#include <new>

#include "softcd/core/count.hpp"

namespace softcd {

/// The chunks in which a detection tests its pairs, so that the lists of one chunk fit into memory.
class ChunkPlan {
 public:
  explicit ChunkPlan(std::uint64_t count) : count_(count) {}

  std::uint64_t count() const { return count_; }

  /// Begins the i-th chunk. Returns its share of the pair tests.
  Share begin(std::uint32_t i) {
    const auto count = static_cast<std::uint32_t>(count_);
    chunk_ = (first_ + i) % count;
    return {chunk_, count};
  }

  /// Makes at least so many chunks, as far as there may be so many.
  void require(std::uint64_t least) { count_ = std::max(count_, std::min(kMost, least)); }

  /// Makes more chunks. `bytes` is the size of the largest chunk's lists, for which there are only `available` bytes.
  /// If `begins_there`, the chunk in which memory ran out comes first: so it shows at once whether its lists fit now.
  /// Throws std::bad_alloc if there can be no more chunks.
  void divide(std::uint64_t bytes, std::uint64_t available, bool begins_there) {
    if (count_ == kMost) throw std::bad_alloc();
    const std::uint64_t parts = bytes / std::max<std::uint64_t>(available, 1) + 1;
    const std::uint64_t failed = chunk_ * kMost / count_;
    count_ = std::min(kMost, count_ * std::clamp<std::uint64_t>(parts, 2, kMost));
    if (begins_there) first_ = static_cast<std::uint32_t>(failed * count_ / kMost);
  }

 private:
  static constexpr std::uint64_t kMost = 4096;

  std::uint64_t count_;
  std::uint32_t chunk_ = 0;  ///< the current one, or the one in which memory ran out
  std::uint32_t first_ = 0;
};

}  // namespace softcd
