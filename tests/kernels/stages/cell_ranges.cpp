#include "softcd/stages/cell_ranges.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

std::vector<std::uint32_t> random_keys(std::uint64_t seed, std::uint32_t count, std::uint32_t cell_count) {
  Random random(seed);
  std::vector<std::uint32_t> keys;
  for (std::uint32_t i = 0; i < count; ++i) keys.push_back(entry_key(random.below(cell_count), random.below(8)));
  std::sort(keys.begin(), keys.end());
  return keys;
}

struct Ranges {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> count;
  Collector<std::uint32_t> cells;
};

template <class Control>
Ranges ranges_of(const std::vector<std::uint32_t>& keys) {
  Ranges ranges{std::vector<std::uint32_t>(keys.size()), std::vector<std::uint32_t>(keys.size()), {}};
  const CountPartners<Control> stage{keys.data(), ranges.begin.data(), ranges.count.data()};
  for (std::uint32_t j = 0; j < keys.size(); ++j) stage(j, ranges.cells);
  return ranges;
}

class CellRanges : public testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {};

TEST_P(CellRanges, every_pair_of_a_cell_that_can_execute_is_enumerated_once) {
  const auto [count, cell_count] = GetParam();
  const std::vector<std::uint32_t> keys = random_keys(count, count, cell_count);
  const Ranges ranges = ranges_of<ExactControl>(keys);
  std::uint32_t cells = 0;
  for (std::uint32_t j = 0; j < count; ++j) {
    if (j == 0 || key_cell(keys[j]) != key_cell(keys[j - 1])) ++cells;
    const std::uint32_t first = ranges.begin[j];
    const std::uint32_t last = first + ranges.count[j];
    ASSERT_LE(last, j);
    for (std::uint32_t i = 0; i < j; ++i) {
      const bool can_execute = key_cell(keys[i]) == key_cell(keys[j]) && (key_k(keys[i]) | key_k(keys[j])) == 7U;
      if (can_execute) {
        ASSERT_TRUE(first <= i && i < last) << i << " and " << j;
      }
      if (first <= i && i < last) {
        ASSERT_EQ(key_cell(keys[i]), key_cell(keys[j]));
      }
    }
  }
  EXPECT_EQ(ranges.cells.items.size(), cells);
}

TEST_P(CellRanges, printed_scheme_enumerates_every_pair_of_a_cell) {
  const auto [count, cell_count] = GetParam();
  std::vector<std::uint32_t> keys = random_keys(count, count, cell_count);
  for (std::uint32_t& key : keys) key &= ~7U;
  const Ranges ranges = ranges_of<PaperControl>(keys);
  for (std::uint32_t j = 0; j < count; ++j) {
    const auto first = std::lower_bound(keys.begin(), keys.end(), keys[j]) - keys.begin();
    ASSERT_EQ(ranges.begin[j], first);
    ASSERT_EQ(ranges.count[j], j - first);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CellRanges,
                         testing::Values(std::pair(0U, 1U), std::pair(1U, 1U), std::pair(2U, 1U), std::pair(31U, 3U),
                                         std::pair(32U, 3U), std::pair(33U, 33U), std::pair(1000U, 1U),
                                         std::pair(2000U, 40U), std::pair(2000U, 5000U)));

}  // namespace
}  // namespace softcd::test
