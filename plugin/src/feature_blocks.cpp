#include "feature_blocks.hpp"

#include <algorithm>

namespace softcd {
namespace {

/// Longer ones are not taken again.
constexpr std::uint32_t kLongestReleased = 64;
/// How much longer than needed a block may be that is taken again.
constexpr std::uint32_t kMostExcess = 4;

}  // namespace

void FeatureBlocks::assign(const std::vector<FeatureEnds>& ends, std::uint32_t FeatureEnds::*end) {
  blocks_.clear();
  blocks_.reserve(ends.size());
  end_ = 0;
  for (const FeatureEnds& of_triangle : ends) {
    blocks_.push_back({end_, of_triangle.*end - end_});
    end_ = of_triangle.*end;
  }
  released_.assign(kLongestReleased + 1, {});
}

bool FeatureBlocks::put(Span<std::uint64_t> part, std::uint32_t triangle, const std::vector<std::uint64_t>& features,
                        std::uint64_t part_begin, UnsentRanges& unsent) {
  if (triangle >= blocks_.size()) blocks_.resize(triangle + 1, Block{0, 0});
  Block& block = blocks_[triangle];
  const auto write = [&](const std::vector<std::uint64_t>& values) {
    const auto rest = std::copy(values.begin(), values.end(), part.data() + block.begin);
    std::fill(rest, part.data() + block.begin + block.capacity, kNoFeatures);
    unsent.add(part_begin + block.begin, part_begin + block.begin + block.capacity);
  };
  if (features.size() > block.capacity) {
    write({});
    release(block);
    if (!take(static_cast<std::uint32_t>(features.size()), part.size(), block)) return false;
  }
  write(features);
  return true;
}

void FeatureBlocks::release(const Block& block) {
  if (block.capacity > 0 && block.capacity <= kLongestReleased) released_[block.capacity].push_back(block.begin);
}

bool FeatureBlocks::take(std::uint32_t count, std::size_t part_size, Block& block) {
  for (std::uint32_t capacity = count; capacity <= std::min(count + kMostExcess, kLongestReleased); ++capacity) {
    if (released_[capacity].empty()) continue;
    block = {released_[capacity].back(), capacity};
    released_[capacity].pop_back();
    return true;
  }
  const std::uint32_t capacity = count + count / 8 + 1;
  if (std::size_t{end_} + capacity > part_size) return false;
  block = {end_, capacity};
  end_ += capacity;
  return true;
}

}  // namespace softcd
