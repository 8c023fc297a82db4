#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "host_scene.hpp"
#include "paper/control_bits.hpp"
#include "random.hpp"
#include "softcd/stages/cell_ranges.hpp"

namespace softcd::paper {
namespace {

TEST(PaperPartners, are_all_entries_before_in_the_cell) {
  for (const std::uint32_t cell_count : {1U, 7U, 300U}) {
    constexpr std::uint32_t kCount = 500;
    test::Random random(cell_count);
    std::vector<std::uint32_t> keys;
    for (std::uint32_t i = 0; i < kCount; ++i) keys.push_back(entry_key(random.below(cell_count), 0));
    std::sort(keys.begin(), keys.end());
    Kdop18 volume = empty_kdop();
    extend(volume, Vec3f{1.0F, 2.0F, 5.0F});
    const std::vector<Entry> entries(kCount, Entry{0, 0});
    std::vector<BoxedEntry> boxed(kCount);
    std::vector<std::uint32_t> begin(kCount);
    std::vector<std::uint32_t> count(kCount);
    SceneView scene;
    scene.body_count = 1;
    scene.self_collision = true;
    test::Collector<std::uint32_t> cells;
    const GridParameters grid{1.0F, 1.0F, 0.0F, 1, 1};
    const PrepareEntry<Control, false> prepare{scene,          &volume,      nullptr,      &grid,       keys.data(),
                                               entries.data(), boxed.data(), begin.data(), count.data()};
    for (std::uint32_t j = 0; j < kCount; ++j) {
      prepare(j, cells);
      const auto first = std::lower_bound(keys.begin(), keys.end(), keys[j]) - keys.begin();
      ASSERT_EQ(begin[j], first);
      ASSERT_EQ(count[j], j - first);
    }
  }
}

}  // namespace
}  // namespace softcd::paper
