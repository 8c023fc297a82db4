#pragma once

#include <vector>

#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// Divides the grid's cells among several ranks. Every rank computes the same division from the same data of all ranks.
/// Owned by RankExchange.
class CellShares {
 public:
  /// Gives each rank the same number of cells.
  explicit CellShares(int rank_count);

  Partition of(int rank) const;
  /// Updates the division after a detection. If a rank had more than a tenth more tests than the mean, cells are moved
  /// so that a similar detection would have about as many tests on each rank.
  void balance(const std::vector<TestSamples>& of_ranks);

 private:
  std::vector<std::uint32_t> ends_;  ///< end of each rank's cells
};

}  // namespace softcd
