#include "cell_shares.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace softcd::test {
namespace {

/// A rank whose tests are spread evenly over its share of the cells.
TestSamples evenly(const Partition& share, std::uint64_t tests) {
  TestSamples samples;
  samples.tests = tests;
  const std::uint64_t width = share.end_cell - share.first_cell;
  for (std::uint64_t i = 0; i < kTestSamples; ++i) {
    samples.cells[i] = share.first_cell + static_cast<std::uint32_t>(width * i / kTestSamples);
  }
  return samples;
}

/// How many of the tests have cells of this share.
double tests_in(const Partition& share, const std::vector<TestSamples>& of_ranks) {
  double tests = 0;
  for (const TestSamples& samples : of_ranks) {
    for (const std::uint32_t cell : samples.cells) {
      if (share.has(cell)) tests += static_cast<double>(samples.tests) / kTestSamples;
    }
  }
  return tests;
}

TEST(CellShares, have_about_as_many_tests_wherever_the_most_were) {
  constexpr int kRanks = 4;
  for (int busiest = 0; busiest < kRanks; ++busiest) {
    CellShares shares(kRanks);
    std::vector<TestSamples> of_ranks;
    for (int rank = 0; rank < kRanks; ++rank) {
      of_ranks.push_back(evenly(shares.of(rank), rank == busiest ? 1'000'000 : 200'000));
    }
    shares.balance(of_ranks);
    EXPECT_EQ(shares.of(0).first_cell, 0U);
    EXPECT_EQ(shares.of(kRanks - 1).end_cell, kCellCount);
    for (int rank = 0; rank < kRanks; ++rank) {
      if (rank > 0) {
        EXPECT_EQ(shares.of(rank).first_cell, shares.of(rank - 1).end_cell);
      }
      EXPECT_NEAR(tests_in(shares.of(rank), of_ranks), 400'000, 20'000) << rank << ", busiest " << busiest;
    }
  }
}

}  // namespace
}  // namespace softcd::test
