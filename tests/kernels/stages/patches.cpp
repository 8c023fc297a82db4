#include "softcd/stages/patches.hpp"
#include "softcd/stages/kept_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <set>
#include <vector>

#include "host_scene.hpp"
#include "lanes/patches.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

/// Returns a cloth folded upon itself, a ball in it, triangles here and there, and a ground with few, large ones.
HostScene host_scene(bool continuous) {
  Mesh cloth = crumpled_cloth(16, 12, 0.25, 0.1, 3);
  Mesh ball = moved(icosphere(2, 0.5), {1.5, 1.2, 0.1});
  SoupOptions options;
  options.triangle_count = 120;
  options.half_extent = 2.0;
  options.joined_share = 0.4;
  options.degenerate_share = 0.1;
  Mesh soup = triangle_soup(options);
  Mesh ground = moved(grid_cloth(2, 2, 80.0), {-80.0, -80.0, 0.125});
  for (Mesh* const mesh : {&cloth, &ball, &soup, &ground}) snap_to_grid(mesh->positions, 17);
  const auto start = [](const Mesh& mesh, std::uint64_t seed) {
    Positions3 x = jittered(mesh.positions, 0.2, seed);
    snap_to_grid(x, 17);
    return x;
  };
  return HostScene({{cloth, start(cloth, 1), 0.01F},
                    {ball, start(ball, 2), 0.0F, false},
                    {soup, start(soup, 3), 0.02F},
                    {ground, {}, 0.0F, false}},
                   continuous);
}

/// The stages from triangles to pairs, in a serial loop.
template <bool kSwept>
class SerialPatches {
 public:
  SerialPatches(const SceneView& scene, float cell_size)
      : scene_(scene), bounds_(scene), patches_(scene.patch_count), grid_(grid_of(cell_size)) {
    const BoundPatch<kSwept> bound{scene, bounds_.volumes.data(), ends(), bounds_.shapes.data(), patches_.data()};
    for (std::uint32_t p = 0; p < scene.patch_count; ++p) bound(p);
    const CellRegistrar registrar{scene, bounds_.volumes.data(), bounds_.shapes.data(), &grid_, {}};
    const RegisterPatch register_patch{registrar};
    for (std::uint32_t p = 0; p < scene.patch_count; ++p) {
      const Registration work = register_patch.load_item(p);
      for (std::uint32_t k = 0; k < work.part_count(); ++k) register_patch(work, k, entries_, loose_, patch_pairs_);
    }
    const RegisterTriangle register_triangle{registrar, false, loose_.items.data()};
    for (std::uint32_t i = 0; i < loose_.items.size(); ++i) {
      const Registration work = register_triangle.load_item(i);
      for (std::uint32_t k = 0; k < work.part_count(); ++k) register_triangle(work, k, entries_, splits_, bigs_);
    }
    test_entries();
    const std::uint64_t big_count = bigs_.items.size();
    const TestAgainstBig<kSwept> against_big{pair_test(), bigs_.items.data(), {&big_count, big_count}};
    for (std::uint32_t p = 0; p < scene.patch_count; ++p) against_big(p, pairs_, patch_pairs_);
    const ExpandPatchPair<kSwept> expand{pair_test(), patches_.data(), patch_pairs_.items.data()};
    for (std::uint32_t i = 0; i < patch_pairs_.items.size(); ++i) {
      const PatchWork work = expand.load_item(i);
      std::uint64_t meeting = cpu::UnitLanes<ExpandPatchPair<kSwept>>::may_pass(expand, work, 0, work.part_count());
      for (; meeting != 0; meeting &= meeting - 1) {
        MeetingTriangles candidate{};
        expand.list(work, static_cast<std::uint32_t>(std::countr_zero(meeting)), candidate);
        expand.test_meeting(candidate, pairs_);
      }
    }
  }

  const std::vector<std::uint64_t>& pairs() const { return pairs_.items; }
  /// Returns the stage that keeps this scene's pairs, and whose volumes of the detection are the same.
  template <bool kDetectionIsSwept>
  KeepPatchPair<kDetectionIsSwept> keep() const {
    static_assert(!kSwept);
    const Kdop18* const volumes = bounds_.volumes.data();
    const TriangleShape* const shapes = bounds_.shapes.data();
    return {{{scene_, volumes, nullptr, shapes}, patches_.data(), patch_pairs_.items.data()},
            {scene_, volumes, bounds_.end_volumes.data(), shapes}};
  }
  std::size_t loose_count() const { return loose_.items.size(); }
  std::size_t big_count() const { return bigs_.items.size(); }
  std::size_t patch_pair_count() const { return patch_pairs_.items.size(); }
  const HostVolumes& bounds() const { return bounds_; }

  PairTest<kSwept> pair_test() {
    return {scene_, bounds_.volumes.data(), bounds_.end_volumes.data(), bounds_.shapes.data()};
  }

 private:
  EndVolumes* ends() { return kSwept ? bounds_.end_volumes.data() : nullptr; }

  void test_entries() {
    std::stable_sort(entries_.items.begin(), entries_.items.end(),
                     [](const KeyedEntry& a, const KeyedEntry& b) { return a.key < b.key; });
    std::vector<std::uint32_t> keys;
    std::vector<Entry> sorted;
    for (const KeyedEntry& entry : entries_.items) {
      keys.push_back(entry.key);
      sorted.push_back(entry.entry);
    }
    std::vector<std::uint32_t> begin(keys.size());
    std::vector<std::uint32_t> count(keys.size());
    std::vector<BoxedEntry> boxed(keys.size());
    Collector<std::uint32_t> cells;
    const PrepareEntry<ExactControl, kSwept> prepare{scene_,      bounds_.volumes.data(), ends(),       &grid_,
                                                     keys.data(), sorted.data(),          boxed.data(), begin.data(),
                                                     count.data()};
    for (std::uint32_t j = 0; j < keys.size(); ++j) prepare(j, cells);
    const TestPair<ExactControl, kSwept> test{pair_test(), keys.data(), boxed.data(), begin.data()};
    Collector<std::uint64_t> flagged;
    for (std::uint32_t j = 0; j < keys.size(); ++j) {
      const auto item = test.load_item(j);
      for (std::uint32_t k = 0; k < count[j]; ++k) {
        PairCandidate candidate{};
        if (test.filter(item, k, candidate)) test.test(candidate, pairs_, patch_pairs_, flagged);
      }
    }
    EXPECT_TRUE(flagged.items.empty()) << "nothing is split";
  }

  const SceneView& scene_;
  HostVolumes bounds_;
  std::vector<PatchBounds<kSwept>> patches_;
  GridParameters grid_;
  Collector<KeyedEntry> entries_;
  Collector<SplitRoot> splits_;
  Collector<std::uint32_t> loose_, bigs_;
  Collector<std::uint64_t> pairs_, patch_pairs_;
};

/// The pairs that pass PairTest, and those of them that certainly have a point in common.
template <bool kSwept>
struct AllPairs {
  std::set<std::uint64_t> passing, touching;

  AllPairs(const SceneView& scene, const PairTest<kSwept>& test) {
    for (std::uint32_t a = 0; a < scene.triangle_count; ++a) {
      for (std::uint32_t b = a + 1; b < scene.triangle_count; ++b) {
        const Entry of_a = test.entry_of(a);
        const Entry of_b = test.entry_of(b);
        if (!test.classes_may_touch(test.touchable_classes(of_a), of_b) || !test.own_features(of_a, of_b)) continue;
        if (!overlap(test.volumes[a], test.volumes[b]) || !test.may_touch(of_a, of_b)) continue;
        passing.insert(pair_key(a, b));
        if (share_position(scene, a, b)) touching.insert(pair_key(a, b));
      }
    }
  }

 private:
  static bool share_position(const SceneView& scene, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t v : scene.triangles[a].v) {
      for (const std::uint32_t w : scene.triangles[b].v) {
        if (v == w || scene.x_t1[v] == scene.x_t1[w]) return true;
      }
    }
    return false;
  }
};

template <class Swept>
class PatchStages : public testing::Test {};
using Kinds = testing::Types<std::false_type, std::true_type>;
TYPED_TEST_SUITE(PatchStages, Kinds, );

// Volumes may overlap along all nine axes and still have no point in common. So sharing a cell is a slightly stronger
// condition.
TYPED_TEST(PatchStages, find_each_pair_of_triangles_once) {
  const HostScene host = host_scene(TypeParam::value);
  const SceneView scene = host.view_with_patches();
  for (const float cell_size : {0.1F, 0.4F, 1.0F, 3.0F}) {
    SCOPED_TRACE(cell_size);
    SerialPatches<TypeParam::value> serial(scene, cell_size);
    const AllPairs<TypeParam::value> all(scene, serial.pair_test());
    const std::set<std::uint64_t> found(serial.pairs().begin(), serial.pairs().end());
    EXPECT_EQ(found.size(), serial.pairs().size()) << "some twice";
    EXPECT_TRUE(std::includes(all.passing.begin(), all.passing.end(), found.begin(), found.end()));
    EXPECT_TRUE(std::includes(found.begin(), found.end(), all.touching.begin(), all.touching.end()));
    EXPECT_GT(found.size(), 9 * all.passing.size() / 10);
    EXPECT_GT(all.touching.size(), 500U);
    EXPECT_GT(serial.loose_count(), cell_size < 0.5F ? 50U : 10U);
    if (cell_size < 0.3F) {
      EXPECT_GT(serial.big_count(), 1U) << "the ground";
    }
    if (cell_size > 0.3F) {
      EXPECT_GT(serial.patch_pair_count(), 50U);
    }
  }
}

/// Returns the values without the first `count`, sorted.
std::vector<std::uint64_t> sorted_from(const std::vector<std::uint64_t>& values, std::size_t count) {
  std::vector<std::uint64_t> rest(values.begin() + static_cast<std::ptrdiff_t>(count), values.end());
  std::sort(rest.begin(), rest.end());
  return rest;
}

// The pairs to keep are all whose volumes overlap. The detection's own pairs are those that TestKept finds among them.
TYPED_TEST(PatchStages, keep_all_pairs_and_find_those_of_the_detection) {
  HostScene host = host_scene(TypeParam::value);
  const SceneView scene = host.view_with_patches();
  for (std::uint32_t b = 0; b < scene.body_count; ++b) host.body(b).lists_neighbours = scene.bodies_may_touch(b, b);
  const SerialPatches<false> serial(scene, 1.0F);
  const auto keep = serial.template keep<TypeParam::value>();
  Collector<std::uint64_t> kept, found;
  using Lanes = cpu::UnitLanes<KeepPatchPair<TypeParam::value>>;
  for (std::uint32_t i = 0; i < serial.patch_pair_count(); ++i) {
    const PatchWork work = keep.load_item(i);
    std::uint64_t meeting = Lanes::may_pass(keep, work, 0, work.part_count());
    for (; meeting != 0; meeting &= meeting - 1) {
      MeetingTriangles candidate{};
      keep.list(work, static_cast<std::uint32_t>(std::countr_zero(meeting)), candidate);
      keep.test_meeting(candidate, kept, found);
    }
  }
  ASSERT_GT(kept.items.size(), 100U);
  EXPECT_EQ(sorted_from(kept.items, 0), sorted_from(serial.pairs(), serial.pairs().size() - kept.items.size()));
  Collector<std::uint64_t> expected;
  const TestKept<TypeParam::value> test_kept{keep.test, kept.items.data(), 0U};
  for (std::uint32_t i = 0; i < kept.items.size(); ++i) test_kept(i, expected);
  EXPECT_EQ(found.items, expected.items);
  EXPECT_GT(found.items.size(), 50U);
  if (TypeParam::value) {
    EXPECT_LT(found.items.size(), kept.items.size());
  }
}

// Whichever triangles have escaped, TestKept and LookUpEscaped together find each pair once.
TYPED_TEST(PatchStages, have_no_part_in_pairs_of_escaped_triangles) {
  const HostScene host = host_scene(TypeParam::value);
  const SceneView scene = host.view_with_patches();
  HostVolumes bounds(scene);
  const PairTest<TypeParam::value> test{scene, bounds.volumes.data(), bounds.end_volumes.data(), bounds.shapes.data()};
  const AllPairs<TypeParam::value> all(scene, test);
  const std::vector<std::uint64_t> pairs(all.passing.begin(), all.passing.end());
  Random random(2);
  for (const std::uint32_t wanted : {0U, 1U, 2U, 15U, 16U, 17U, 40U, kMostEscaped}) {
    SCOPED_TRACE(wanted);
    std::set<std::uint32_t> chosen;
    while (chosen.size() < std::min(wanted, scene.triangle_count / 2)) {
      const std::uint32_t first = random.below(scene.triangle_count);
      for (std::uint32_t t = first; t < std::min(first + 3, scene.triangle_count); ++t) chosen.insert(t);
    }
    std::vector<std::uint32_t> escaped(chosen.begin(), chosen.end());
    for (TriangleShape& shape : bounds.shapes) shape.flags &= ~kEscapedTriangle;
    for (const std::uint32_t t : escaped) bounds.shapes[t].flags |= kEscapedTriangle;
    const std::uint64_t count = escaped.size();
    std::vector<EscapedGroup> groups(kMostEscaped / kEscapedGroup + 1);
    const EscapedTriangles triangles{escaped.data(), &count};
    const BoundEscaped bound{triangles, scene.triangle_body, bounds.volumes.data(), groups.data()};
    for (std::uint32_t group = 0; group < groups.size(); ++group) bound(group);
    Collector<std::uint64_t> found;
    const TestKept<TypeParam::value> test_kept{test, pairs.data(), kEscapedTriangle};
    for (std::uint32_t i = 0; i < pairs.size(); ++i) test_kept(i, found);
    EXPECT_EQ(found.items.size() == pairs.size(), wanted == 0);
    const LookUpEscaped<TypeParam::value> look_up{test, triangles, groups.data()};
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) look_up(t, found);
    std::sort(found.items.begin(), found.items.end());
    EXPECT_EQ(found.items, pairs);
  }
}

TYPED_TEST(PatchStages, bound_all_triangles_of_a_patch) {
  const HostScene host = host_scene(TypeParam::value);
  const SceneView scene = host.view_with_patches();
  const SerialPatches<TypeParam::value> serial(scene, 0.5F);
  int whole = 0;
  for (std::uint32_t p = 0; p < scene.patch_count; ++p) {
    const std::uint32_t element = scene.patch_element(p);
    if (is_empty(serial.bounds().volumes[element])) continue;
    ++whole;
    for (std::uint32_t i = 0; i < kPatchSize; ++i) {
      const std::uint32_t t = scene.element_triangle(element, i);
      if (t == kNoIndex || is_empty(serial.bounds().volumes[t])) continue;
      EXPECT_TRUE(contains(serial.bounds().volumes[element], serial.bounds().volumes[t]));
      EXPECT_LE(serial.bounds().shapes[t].growth, serial.bounds().shapes[element].growth);
      EXPECT_EQ(serial.bounds().shapes[t].flags & ~serial.bounds().shapes[element].flags & ~kBigTriangle, 0U);
    }
  }
  EXPECT_GT(whole, 40);
}

/// Returns a volume of finite numbers of either sign.
template <class Volume>
Volume random_volume(Random& random) {
  Volume volume{};
  auto* const values = reinterpret_cast<float*>(&volume);
  for (std::size_t i = 0; i < 2 * kKdopAxes * (std::is_same_v<Volume, EndVolumes> ? 2 : 1); ++i) {
    values[i] = static_cast<float>(random.uniform(-9.0, 9.0));
  }
  return volume;
}

template <class T>
bool have_same_bytes(const T& a, const T& b) {
  using Bytes = std::array<unsigned char, sizeof(T)>;
  return std::bit_cast<Bytes>(a) == std::bit_cast<Bytes>(b);
}

template <bool kSwept>
void expect_twins_to_agree() {
  using Volume = std::conditional_t<kSwept, EndVolumes, Kdop18>;
  constexpr int kRows = kKdopAxes * PatchBounds<kSwept>::kEnds;
  Random random(4);
  for (int round = 0; round < 1000; ++round) {
    PatchBounds<kSwept> patch{};
    PatchBounds<kSwept> expected{};
    for (std::uint32_t first = 0; first < kPatchSize; first += 4) {
      Volume volumes[4];
      const Volume* four[4];
      for (int i = 0; i < 4; ++i) {
        volumes[i] = random_volume<Volume>(random);
        four[i] = volumes + i;
      }
      lay_four(patch, first, four);
      generic::lay_four(expected, first, four);
    }
    ASSERT_TRUE(have_same_bytes(patch, expected));
    const float* const lo = &patch.lo[0][0][0];
    const float* const hi = &patch.hi[0][0][0];
    const auto least = bounds_of_rows<false, kRows>(lo);
    const auto greatest = bounds_of_rows<true, kRows>(hi);
    const auto expected_least = generic::bounds_of_rows<false, kRows>(lo);
    const auto expected_greatest = generic::bounds_of_rows<true, kRows>(hi);
    ASSERT_TRUE(have_same_bytes(least, expected_least));
    ASSERT_TRUE(have_same_bytes(greatest, expected_greatest));
  }
}

TEST(PatchTwins, lay_and_bound_alike) {
  expect_twins_to_agree<true>();
  expect_twins_to_agree<false>();
}

}  // namespace
}  // namespace softcd::test
