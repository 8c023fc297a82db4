#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/topology.hpp"
#include "unsent_ranges.hpp"

namespace softcd {

/// Where each triangle's features are in a body's part of a list of neighbours' features: one behind the other, and
/// kNoFeatures behind them where there once were more. What one triangle has no room for any more another may take.
class FeatureBlocks {
 public:
  /// The part begins with each triangle's up to its `end`, and there is nothing behind.
  void assign(const std::vector<FeatureEnds>& ends, std::uint32_t FeatureEnds::*end);
  /// Puts a triangle's features into the part, which begins in the list where `unsent` says. False where they do not
  /// fit.
  bool put(Span<std::uint64_t> part, std::uint32_t triangle, const std::vector<std::uint64_t>& features,
           std::uint64_t part_begin, UnsentRanges& unsent);

 private:
  struct Block {
    std::uint32_t begin, capacity;
  };

  void release(const Block& block);
  bool take(std::uint32_t count, std::size_t part_size, Block& block);

  std::vector<Block> blocks_;
  std::vector<std::vector<std::uint32_t>> released_;  ///< where blocks of each capacity begin
  std::uint32_t end_ = 0;                             ///< of all blocks
};

}  // namespace softcd
