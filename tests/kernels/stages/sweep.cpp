#include "softcd/stages/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "host_scene.hpp"
#include "softcd/core/team.hpp"
#include "softcd/stages/pair_tests.hpp"

namespace softcd::test {
namespace {

/// The stages of a sweep, run over a scene.
struct HostSweep {
  HostVolumes bounded;
  Sweep sweep{};
  GridParameters grid{};
  std::vector<std::uint32_t> keys;
  std::vector<Entry> entries;
  std::vector<BoxedEntry> boxed;
  std::vector<std::uint32_t> partner_begin, partner_count;

  explicit HostSweep(const SceneView& scene) : bounded(scene) {
    const std::uint64_t all = scene.triangle_count;
    SerialTeam team;
    ChooseSweep{bounded.volumes.data(), bounded.shapes.data(), {&all, all}, &sweep, &grid}(team);
    register_triangles(scene);
    scene.is_swept ? prepare_entries<true>() : prepare_entries<false>();
  }

 private:
  void register_triangles(const SceneView& scene) {
    Collector<KeyedEntry> collected;
    const RegisterForSweep stage{scene, bounded.volumes.data(), bounded.shapes.data(), &sweep};
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) stage(t, collected);
    std::vector<KeyedEntry>& sorted = collected.items;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const KeyedEntry& a, const KeyedEntry& b) { return a.key < b.key; });
    for (const KeyedEntry& entry : sorted) {
      EXPECT_LT(entry.key, 1U << kSweepKeyBits);
      keys.push_back(entry.key);
      entries.push_back(entry.entry);
    }
  }

  template <bool kSwept>
  void prepare_entries() {
    const std::uint64_t count = entries.size();
    boxed.resize(count);
    partner_begin.resize(count);
    partner_count.resize(count);
    const PrepareSweptEntry<kSwept> stage{bounded.volumes.data(),
                                          bounded.end_volumes.data(),
                                          &sweep,
                                          {&count, count},
                                          keys.data(),
                                          entries.data(),
                                          boxed.data(),
                                          partner_begin.data(),
                                          partner_count.data()};
    for (std::uint32_t j = 0; j < count; ++j) stage(j);
  }
};

template <bool kSwept>
std::vector<std::uint64_t> swept_pairs(const SceneView& scene) {
  const HostSweep swept(scene);
  const TestPair<ExactControl, kSwept> test_pair{
      {scene, swept.bounded.volumes.data(), swept.bounded.end_volumes.data(), swept.bounded.shapes.data()},
      swept.keys.data(),
      swept.boxed.data(),
      swept.partner_begin.data()};
  Collector<std::uint64_t> pairs, patch_pairs, flagged;
  for (std::uint32_t j = 0; j < swept.entries.size(); ++j) {
    const auto item = test_pair.load_item(j);
    PairCandidate candidate{};
    for (std::uint32_t k = 0; k < swept.partner_count[j]; ++k) {
      if (test_pair.filter(item, k, candidate)) test_pair.test(candidate, pairs, patch_pairs, flagged);
    }
  }
  EXPECT_TRUE(flagged.items.empty());
  std::sort(pairs.items.begin(), pairs.items.end());
  return pairs.items;
}

/// Returns the pairs whose volumes overlap, by comparing all.
template <bool kSwept>
std::vector<std::uint64_t> every_pair(const SceneView& scene) {
  const HostVolumes bounded(scene);
  const PairTest<kSwept> test{scene, bounded.volumes.data(), bounded.end_volumes.data(), bounded.shapes.data()};
  std::vector<std::uint64_t> pairs;
  for (std::uint32_t a = 0; a < scene.triangle_count; ++a) {
    for (std::uint32_t b = a + 1; b < scene.triangle_count; ++b) {
      if (!overlap(bounded.volumes[a], bounded.volumes[b])) continue;
      const Entry entry_a = test.entry_of(a);
      const Entry entry_b = test.entry_of(b);
      if (!test.classes_may_touch(test.touchable_classes(entry_a), entry_b)) continue;
      if (test.own_features(entry_a, entry_b) && test.may_touch(entry_a, entry_b)) pairs.push_back(pair_key(a, b));
    }
  }
  return pairs;
}

Mesh soup(std::uint32_t count, std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = count;
  options.joined_share = 0.4;
  options.degenerate_share = 0.05;
  options.seed = seed;
  return triangle_soup(options);
}

HostBody body_of(const Mesh& mesh, double motion, bool self_collision, float margin = 0.05F) {
  return {mesh, scattered(mesh, motion, 7), margin, self_collision};
}

TEST(Sweep, finds_every_pair_of_volumes_that_overlap_once) {
  for (const bool self_collision : {true, false}) {
    const std::vector<HostBody> bodies = {body_of(soup(300, 1), 0.7, self_collision),
                                          body_of(soup(200, 2), 0.0, self_collision, 0.0F),
                                          body_of(soup(100, 3), 0.2, true)};
    const HostScene moving(bodies, true);
    const HostScene still(bodies, false);
    EXPECT_EQ(swept_pairs<true>(moving.view()), every_pair<true>(moving.view()));
    EXPECT_EQ(swept_pairs<false>(still.view()), every_pair<false>(still.view()));
    EXPECT_GT(swept_pairs<false>(still.view()).size(), 500U);
  }
}

// More bodies than there are bits or classes.
TEST(Sweep, finds_every_pair_of_many_bodies) {
  std::vector<HostBody> bodies;
  for (std::uint64_t seed = 0; seed < 40; ++seed) bodies.push_back(body_of(soup(20, seed), 0.3, seed % 3 == 0));
  const HostScene scene(bodies, false);
  EXPECT_EQ(swept_pairs<false>(scene.view()), every_pair<false>(scene.view()));
}

TEST(Sweep, finds_every_pair_far_from_the_origin_and_in_a_line) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 200; ++i) mesh = joined(mesh, moved(soup(2, i), {20.0 * (i % 50), 0.0, 0.0}));
  const HostScene line({body_of(mesh, 0.0, true)}, false);
  EXPECT_EQ(swept_pairs<false>(line.view()), every_pair<false>(line.view()));
  const HostScene distant({body_of(moved(soup(300, 5), {4096.0, -2048.0, 0.0}), 0.0, true)}, false);
  EXPECT_EQ(swept_pairs<false>(distant.view()), every_pair<false>(distant.view()));
}

TEST(Sweep, goes_along_the_axis_with_the_fewest_tests) {
  const Mesh cloth = grid_cloth(40, 3, 0.1);
  const HostScene scene({body_of(cloth, 0.0, true)}, false);
  const HostSweep swept(scene.view());
  EXPECT_TRUE(swept.sweep.is_possible);
  EXPECT_EQ(swept.sweep.axis, 0);
  const std::uint32_t tests = std::accumulate(swept.partner_count.begin(), swept.partner_count.end(), 0U);
  EXPECT_LT(tests, 20U * cloth.triangles.size());
}

TEST(Sweep, a_body_that_does_not_touch_itself_is_skipped_by_its_bit) {
  const HostScene scene({body_of(soup(10, 1), 0.0, true), body_of(soup(10, 2), 0.0, false)}, false);
  const HostSweep swept(scene.view());
  for (const Entry entry : swept.entries) {
    const std::uint32_t mask = entry.bits & ((1U << kMaskBits) - 1U);
    EXPECT_EQ(mask, body_class(entry) == 0 ? 0U : 2U);
  }
}

TEST(Sweep, leaves_uneven_triangles_and_single_points_to_the_grid) {
  Mesh mesh = grid_cloth(10, 10, 0.1);
  const HostScene even({body_of(mesh, 0.0, true, 0.01F)}, false);
  EXPECT_TRUE(HostSweep(even.view()).sweep.is_possible);
  mesh.positions.push_back({5.0, 5.0, 5.0});
  mesh.triangles.push_back({{0, 1, 100}});
  const HostScene uneven({body_of(mesh, 0.0, true, 0.01F)}, false);
  EXPECT_FALSE(HostSweep(uneven.view()).sweep.is_possible);
  const Mesh point = {{{{0, 1, 2}}}, {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
  const HostScene points({{point, {}, 0.0F}}, false);
  EXPECT_FALSE(HostSweep(points.view()).sweep.is_possible);
}

}  // namespace
}  // namespace softcd::test
