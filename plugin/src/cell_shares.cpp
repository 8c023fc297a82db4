#include "cell_shares.hpp"

#include <algorithm>

namespace softcd {

CellShares::CellShares(int rank_count) {
  for (int rank = 0; rank < rank_count; ++rank) {
    ends_.push_back(static_cast<std::uint32_t>(
        Share{static_cast<std::uint32_t>(rank), static_cast<std::uint32_t>(rank_count)}.end(kCellCount)));
  }
}

Partition CellShares::of(int rank) const {
  const auto i = static_cast<std::size_t>(rank);
  const Share share = {static_cast<std::uint32_t>(rank), static_cast<std::uint32_t>(ends_.size())};
  return {share, i == 0 ? 0 : ends_[i - 1], ends_[i]};
}

void CellShares::balance(const std::vector<TestSamples>& of_ranks) {
  std::uint64_t all = 0;
  std::uint64_t most = 0;
  for (const TestSamples& samples : of_ranks) {
    all += samples.tests;
    most = std::max(most, samples.tests);
  }
  const std::uint64_t count = ends_.size();
  if (10 * most * count <= 11 * all) return;
  // Samples ascend, also from rank to rank. The samples of one rank divide its tests evenly.
  std::uint64_t before = 0;
  std::size_t next = 0;
  for (const TestSamples& samples : of_ranks) {
    for (std::uint64_t i = 0; i < kTestSamples && samples.tests > 0; ++i) {
      const std::uint64_t tests = before + samples.tests * i / kTestSamples;
      while (next + 1 < count && tests >= all * (next + 1) / count) ends_[next++] = samples.cells[i];
    }
    before += samples.tests;
  }
  while (next + 1 < count) ends_[next++] = kCellCount;
}

}  // namespace softcd
