#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "host_scene.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/pair_tests.hpp"
#include "split_triangles.hpp"

namespace softcd::test {
namespace {

template <bool kContinuous>
PairTest<kContinuous> pair_test(const SceneView& scene, const HostVolumes& bounds) {
  return {scene, bounds.volumes.data(), bounds.end_volumes.data(), bounds.shapes.data()};
}

/// The stages from cells to pairs in a serial loop.
template <bool kContinuous>
class SerialBroadPhase {
 public:
  SerialBroadPhase(const SceneView& scene, float cell_size, bool subdivision)
      : scene_(scene), bounds_(scene), grid_(grid_of(cell_size)) {
    const RegisterTriangle whole{{scene, bounds_.volumes.data(), bounds_.shapes.data(), &grid_, {}}, subdivision};
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
      const Registration work = whole.load_item(t);
      for (std::uint32_t part = 0; part < work.part_count(); ++part) whole(work, part, entries_, splits_, bigs_);
    }
    register_split_triangles(scene_, bounds_.volumes.data(), bounds_.shapes.data(), splits_.items, grid_, entries_);
    sort_entries();
    test_pairs();
    const std::uint64_t big_count = bigs_.items.size();
    const TestAgainstBig<kContinuous> against_big{
        pair_test<kContinuous>(scene, bounds_), bigs_.items.data(), {&big_count, big_count}};
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) against_big(t, pairs_, patch_pairs_);
  }

  const std::vector<std::uint64_t>& pairs() const { return pairs_.items; }
  const std::vector<std::uint64_t>& flagged() const { return flagged_.items; }
  std::size_t split_count() const { return splits_.items.size(); }
  std::size_t big_count() const { return bigs_.items.size(); }
  const HostVolumes& bounds() const { return bounds_; }

  std::set<std::uint64_t> distinct_pairs() const {
    std::set<std::uint64_t> pairs(pairs_.items.begin(), pairs_.items.end());
    pairs.insert(flagged_.items.begin(), flagged_.items.end());
    return pairs;
  }

 private:
  void sort_entries() {
    std::stable_sort(entries_.items.begin(), entries_.items.end(),
                     [](const KeyedEntry& a, const KeyedEntry& b) { return a.key < b.key; });
    for (const KeyedEntry& entry : entries_.items) {
      keys_.push_back(entry.key);
      sorted_.push_back(entry.entry);
    }
  }

  void test_pairs() {
    std::vector<std::uint32_t> begin(keys_.size());
    std::vector<std::uint32_t> count(keys_.size());
    std::vector<BoxedEntry> boxed(keys_.size());
    Collector<std::uint32_t> cells;
    const PrepareEntry<ExactControl, kContinuous> prepare{
        scene_,       bounds_.volumes.data(), kContinuous ? bounds_.end_volumes.data() : nullptr,
        &grid_,       keys_.data(),           sorted_.data(),
        boxed.data(), begin.data(),           count.data()};
    for (std::uint32_t j = 0; j < keys_.size(); ++j) prepare(j, cells);
    const TestPair<ExactControl, kContinuous> test{pair_test<kContinuous>(scene_, bounds_), keys_.data(), boxed.data(),
                                                   begin.data()};
    for (std::uint32_t j = 0; j < keys_.size(); ++j) {
      for (std::uint32_t k = 0; k < count[j]; ++k) {
        PairCandidate candidate{};
        if (test.filter(test.load_item(j), k, candidate)) test.test(candidate, pairs_, patch_pairs_, flagged_);
      }
    }
  }

  const SceneView& scene_;
  HostVolumes bounds_;
  GridParameters grid_;
  Collector<KeyedEntry> entries_;
  Collector<SplitRoot> splits_;
  Collector<std::uint32_t> bigs_;
  std::vector<std::uint32_t> keys_;
  std::vector<Entry> sorted_;
  Collector<std::uint64_t> pairs_, patch_pairs_;
  Collector<std::uint64_t> flagged_;
};

/// Returns every pair that passes PairTest, by testing all.
template <bool kContinuous>
std::set<std::uint64_t> all_pairs(const SceneView& scene, const HostVolumes& bounds) {
  const auto test = pair_test<kContinuous>(scene, bounds);
  const auto entry = [&](std::uint32_t t) {
    return Entry{t, entry_bits(0, scene.triangle_body[t], wanted_features(bounds.shapes[t].flags))};
  };
  std::set<std::uint64_t> pairs;
  for (std::uint32_t a = 0; a < scene.triangle_count; ++a) {
    for (std::uint32_t b = a + 1; b < scene.triangle_count; ++b) {
      const Entry entry_a = entry(a);
      const Entry entry_b = entry(b);
      const bool may_meet = test.classes_may_touch(test.touchable_classes(entry_a), entry_b);
      const bool overlapping = overlap(bounds.volumes[a], bounds.volumes[b]);
      if (may_meet && overlapping && test.own_features(entry_a, entry_b) && test.may_touch(entry_a, entry_b)) {
        pairs.insert(pair_key(a, b));
      }
    }
  }
  return pairs;
}

std::size_t count_repeated(std::vector<std::uint64_t> pairs) {
  const std::size_t count = pairs.size();
  std::sort(pairs.begin(), pairs.end());
  return count - static_cast<std::size_t>(std::unique(pairs.begin(), pairs.end()) - pairs.begin());
}

/// Returns the pairs of `pairs` that share a cell, or have a triangle that is too large for the grid.
std::set<std::uint64_t> meeting_pairs(const std::set<std::uint64_t>& pairs, const HostVolumes& bounds,
                                      float cell_size) {
  const auto cells = [&](std::uint64_t t) { return integer_dop(bounds.volumes[t & 0xFFFFFFFFU], 1.0F / cell_size); };
  std::set<std::uint64_t> meeting;
  for (const std::uint64_t pair : pairs) {
    const IntegerDop a = cells(pair >> 32);
    const IntegerDop b = cells(pair);
    bool meets = a.span() > kMaxSpan || b.span() > kMaxSpan;
    for (int z = std::max(a.lo[2], b.lo[2]); z <= std::min(a.hi[2], b.hi[2]) && !meets; ++z) {
      for (int y = std::max(a.lo[1], b.lo[1]); y <= std::min(a.hi[1], b.hi[1]) && !meets; ++y) {
        const CellInterval row_a = a.row(y, z);
        const CellInterval row_b = b.row(y, z);
        meets = std::max(row_a.lo, row_b.lo) <= std::min(row_a.hi, row_b.hi);
      }
    }
    if (meets) meeting.insert(pair);
  }
  return meeting;
}

bool contains_all(const std::set<std::uint64_t>& all, const std::set<std::uint64_t>& part) {
  return std::includes(all.begin(), all.end(), part.begin(), part.end());
}

/// Returns the pairs of `pairs` whose triangles have a corner in common at t1.
std::set<std::uint64_t> surely_touching(const SceneView& scene, const std::set<std::uint64_t>& pairs) {
  std::set<std::uint64_t> touching;
  for (const std::uint64_t pair : pairs) {
    const auto a = static_cast<std::uint32_t>(pair >> 32);
    const auto b = static_cast<std::uint32_t>(pair);
    for (const std::uint32_t v : scene.triangles[a].v) {
      for (const std::uint32_t w : scene.triangles[b].v) {
        if (v == w || scene.x_t1[v] == scene.x_t1[w]) touching.insert(pair);
      }
    }
  }
  return touching;
}

Mesh soup(std::uint64_t seed, double ratio, int grid_bits) {
  SoupOptions options;
  options.triangle_count = 400;
  options.half_extent = 3.0;
  options.largest = ratio > 1.0 ? 4.0 : 0.5;
  options.size_ratio = ratio;
  options.joined_share = 0.3;
  options.degenerate_share = 0.05;
  options.grid_bits = grid_bits;
  options.seed = seed;
  return triangle_soup(options);
}

HostScene host_scene(std::uint64_t seed, double ratio, bool continuous, int grid_bits = 17) {
  const Mesh mesh = soup(seed, ratio, grid_bits);
  Positions3 start = jittered(mesh.positions, 1.0, seed);
  snap_to_grid(start, grid_bits);
  return HostScene({{mesh, start, continuous ? 0.0F : 0.01F}, {moved(mesh, {0.25, 0.5, 0}), {}, 0.0F, false}},
                   continuous);
}

/// Test suite whose type says whether the detection is continuous.
template <class Continuous>
class SerialStages : public testing::Test {};
using Kinds = testing::Types<std::false_type, std::true_type>;
TYPED_TEST_SUITE(SerialStages, Kinds, );

// Without subdivision the grid enumerates exactly the pairs that pass PairTest and share a cell, once, whatever the
// cell size. Volumes may overlap along all nine axes and still have no point in common, so sharing a cell is a slightly
// stronger condition.
TYPED_TEST(SerialStages, whole_triangles_meet_as_their_volumes_do) {
  const HostScene host = host_scene(1, 50.0, TypeParam::value);
  const SceneView scene = host.view();
  for (const float cell_size : {0.06F, 0.25F, 0.3F, 1.0F, 3.7F}) {
    const SerialBroadPhase<TypeParam::value> serial(scene, cell_size, false);
    EXPECT_EQ(count_repeated(serial.pairs()), 0U);
    EXPECT_TRUE(serial.flagged().empty());
    const std::set<std::uint64_t> bound = all_pairs<TypeParam::value>(scene, serial.bounds());
    const std::set<std::uint64_t> found = serial.distinct_pairs();
    EXPECT_TRUE(found == meeting_pairs(bound, serial.bounds(), cell_size)) << "cell size " << cell_size;
    EXPECT_TRUE(contains_all(found, surely_touching(scene, bound)));
    EXPECT_GT(found.size(), 9 * bound.size() / 10);
  }
}

// With subdivision a pair whose volumes overlap may be dropped only if the triangles are apart. Pairs with a common
// point are kept. Pairs that are not flagged are found once.
TYPED_TEST(SerialStages, split_triangles_that_touch_meet) {
  for (const std::uint64_t seed : {2U, 3U}) {
    const HostScene host = host_scene(seed, 200.0, TypeParam::value);
    const SceneView scene = host.view();
    for (const float cell_size : {0.1F, 0.2F}) {
      const SerialBroadPhase<TypeParam::value> serial(scene, cell_size, true);
      EXPECT_GT(serial.split_count(), 10U);
      EXPECT_EQ(count_repeated(serial.pairs()), 0U) << "cell size " << cell_size;
      const std::set<std::uint64_t> found = serial.distinct_pairs();
      const std::set<std::uint64_t> bound = all_pairs<TypeParam::value>(scene, serial.bounds());
      EXPECT_TRUE(contains_all(bound, found));
      const std::set<std::uint64_t> required = surely_touching(scene, bound);
      EXPECT_GT(required.size(), 50U);
      EXPECT_TRUE(contains_all(found, required));
    }
  }
}

// Corners are exactly on the cells' walls, where rounding slack moves a child's volume into the next cell.
TYPED_TEST(SerialStages, corners_on_cell_walls) {
  for (std::uint64_t seed = 5; seed < 9; ++seed) {
    const HostScene host = host_scene(seed, 10.0, TypeParam::value, 1);
    const SceneView scene = host.view();
    for (const float cell_size : {0.25F, 0.5F, 1.0F}) {
      for (const bool subdivision : {false, true}) {
        const SerialBroadPhase<TypeParam::value> serial(scene, cell_size, subdivision);
        EXPECT_EQ(count_repeated(serial.pairs()), 0U) << "cell size " << cell_size;
        const std::set<std::uint64_t> found = serial.distinct_pairs();
        const std::set<std::uint64_t> bound = all_pairs<TypeParam::value>(scene, serial.bounds());
        const std::set<std::uint64_t> required = surely_touching(scene, bound);
        EXPECT_TRUE(contains_all(found, required));
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test
