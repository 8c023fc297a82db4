#include "softcd/stages/cell_ranges.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
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
  std::vector<BoxedEntry> boxed;
  Collector<std::uint32_t> cells;

  bool contain(std::uint32_t i, std::uint32_t j) const { return begin[j] <= i && i < begin[j] + count[j]; }
};

/// Returns ranges in which entry j belongs to triangle j % 3.
Ranges ranges_of(const SceneView& scene, const std::vector<std::uint32_t>& keys) {
  std::vector<Kdop18> volumes(3, empty_kdop());
  for (std::uint32_t t = 0; t < 3; ++t) extend(volumes[t], Vec3f{static_cast<float>(t), 2.0F, 5.0F});
  std::vector<Entry> entries;
  for (std::uint32_t j = 0; j < keys.size(); ++j) entries.push_back({j % 3, j});
  Ranges ranges{std::vector<std::uint32_t>(keys.size()),
                std::vector<std::uint32_t>(keys.size()),
                std::vector<BoxedEntry>(keys.size()),
                {}};
  const GridParameters grid{1.0F, 1.0F, 0.0F, 3, 3};
  const PrepareEntry<ExactControl, false> stage{scene,
                                                volumes.data(),
                                                nullptr,
                                                &grid,
                                                keys.data(),
                                                entries.data(),
                                                ranges.boxed.data(),
                                                ranges.begin.data(),
                                                ranges.count.data()};
  for (std::uint32_t j = 0; j < keys.size(); ++j) stage(j, ranges.cells);
  return ranges;
}

SceneView scene_of(std::uint32_t body_count, bool self_collision) {
  SceneView scene;
  scene.body_count = body_count;
  scene.self_collision = self_collision;
  return scene;
}

class CellRanges : public testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {};

TEST_P(CellRanges, every_pair_of_a_cell_that_can_execute_is_enumerated_once) {
  const auto [count, cell_count] = GetParam();
  const std::vector<std::uint32_t> keys = random_keys(count, count, cell_count);
  const Ranges ranges = ranges_of(scene_of(1, true), keys);
  std::uint32_t cells = 0;
  for (std::uint32_t j = 0; j < count; ++j) {
    if (j == 0 || key_cell(keys[j]) != key_cell(keys[j - 1])) ++cells;
    const std::uint32_t first = ranges.begin[j];
    const std::uint32_t last = first + ranges.count[j];
    ASSERT_LE(last, j);
    for (std::uint32_t i = 0; i < j; ++i) {
      const std::uint32_t k_i = 7U - key_rank(keys[i]);
      const std::uint32_t k_j = 7U - key_rank(keys[j]);
      const bool can_execute = key_cell(keys[i]) == key_cell(keys[j]) && (k_i | k_j) == 7U;
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

// Ranks are bodies modulo 8 here, so that with more than eight bodies an equal rank says nothing.
TEST_P(CellRanges, without_self_collision_only_other_bodies_are_enumerated) {
  const auto [count, cell_count] = GetParam();
  const std::vector<std::uint32_t> keys = random_keys(count, count, cell_count);
  for (const std::uint32_t bodies : {2U, 8U, 9U, 40U}) {
    const Ranges ranges = ranges_of(scene_of(bodies, false), keys);
    for (std::uint32_t j = 0; j < count; ++j) {
      for (std::uint32_t i = 0; i < j; ++i) {
        const bool differ = bodies > 8 || key_rank(keys[i]) != key_rank(keys[j]);
        ASSERT_EQ(ranges.contain(i, j), key_cell(keys[i]) == key_cell(keys[j]) && differ) << i << " and " << j;
      }
    }
  }
}

TEST(PrepareEntry, lays_the_triangles_boxes_beside_its_entry) {
  const std::vector<std::uint32_t> keys = random_keys(1, 5, 2);
  const Ranges ranges = ranges_of(scene_of(1, true), keys);
  for (std::uint32_t j = 0; j < 5; ++j) {
    const auto x = static_cast<float>(j % 3);
    const BoxedBounds bounds = {{x, x, x + 2.0F, x + 2.0F}, {2.0F, 2.0F, x + 5.0F, x + 5.0F}, {5.0F, 5.0F, 7.0F, 7.0F}};
    const BoxedEntry expected = boxed<false>(bounds, key_cell(keys[j]), 1.0F, {j % 3, j});
    EXPECT_EQ(std::memcmp(&ranges.boxed[j], &expected, sizeof expected), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CellRanges,
                         testing::Values(std::pair(0U, 1U), std::pair(1U, 1U), std::pair(2U, 1U), std::pair(31U, 3U),
                                         std::pair(32U, 3U), std::pair(33U, 33U), std::pair(1000U, 1U),
                                         std::pair(2000U, 40U), std::pair(2000U, 5000U)));

}  // namespace
}  // namespace softcd::test
