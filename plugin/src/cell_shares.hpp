#pragma once

#include <vector>

#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// Which cells each of several ranks has. Every rank computes the same from what all ranks have told each other.
class CellShares {
 public:
  /// As many cells for each.
  explicit CellShares(int rank_count);

  Partition of(int rank) const;
  /// After a detection, what all ranks have tested: where some rank has had more than a tenth more tests than the mean,
  /// cells change hands so that in another such detection all have about as many.
  void balance(const std::vector<TestSamples>& of_ranks);

 private:
  std::vector<std::uint32_t> ends_;  ///< of each rank's cells
};

}  // namespace softcd
