#include "lanes/patches.hpp"

#include <bit>
#include <map>

#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "softcd/stages/patches.hpp"

/// Pairs with a patch become pairs of triangles.
namespace softcd::test {
namespace {

/// Two patches of triangles 0 to 7 and 8 to 15, as many of them as there are, and triangle 16 alone.
class TwoPatches {
 public:
  static constexpr std::uint32_t kTriangles = 17;
  static constexpr std::uint32_t kFirst = kTriangles, kSecond = kTriangles + 1, kSingle = 16;

  TwoPatches() : scene_(kTriangles + 2) {
    for (std::uint32_t t = 0; t < kTriangles; ++t) corners_[t] = {{3 * t, 3 * t + 1, 3 * t + 2}};
    scene_.view().triangle_count = kTriangles;
    scene_.view().patch_count = 2;
    scene_.view().patch_triangles = patches_;
    scene_.view().triangles = corners_;
    scene_.view().self_collision = false;  // whether triangles share vertices is not the matter
    for (TriangleShape& shape : scene_.shapes()) {
      shape.flags = 63U | kWantsVertexTriangle | kWantsEdgeEdge;
      shape.radius = 8.0F;  // so large that no patch is loose
    }
  }

  /// Sets how many triangles the patches have, and which triangles of the first are near all others, by bits. The rest
  /// of them are far away.
  void set(std::uint32_t first_count, std::uint32_t second_count, std::uint32_t near) {
    for (std::uint32_t i = 0; i < kPatchSize; ++i) {
      patches_[i] = i < first_count ? i : kNoIndex;
      patches_[kPatchSize + i] = i < second_count ? kPatchSize + i : kNoIndex;
      scene_.volumes()[i] = place((near >> i & 1U) != 0U ? 0 : 1);
      scene_.volumes()[kPatchSize + i] = place(0);
    }
    scene_.volumes()[kSingle] = place(0);
    for (std::uint32_t patch = 0; patch < 2; ++patch) {
      BoundPatch<false>{scene_.view(), scene_.volumes().data(), nullptr, scene_.shapes().data(), bounds_}(patch);
      for (std::uint32_t i = 0; i < kPatchSize; ++i) {
        const std::uint32_t t = patches_[kPatchSize * patch + i];
        if (t == kNoIndex) continue;
        EXPECT_TRUE(contains(scene_.volumes()[kFirst + patch], scene_.volumes()[t]));
      }
    }
  }

  /// Returns how often each pair of triangles is found, given a pair of elements.
  std::map<std::uint64_t, int> expand(std::uint32_t a, std::uint32_t b) {
    const std::uint64_t pair = pair_key(a, b);
    const ExpandPatchPair<false> stage{
        {scene_.view(), scene_.volumes().data(), nullptr, scene_.shapes().data()}, bounds_, &pair};
    const PatchWork work = stage.load_item(0);
    struct {
      std::map<std::uint64_t, int> counts;
      void push(std::uint64_t key) { ++counts[key]; }
    } pairs;
    std::uint64_t parts = cpu::UnitLanes<ExpandPatchPair<false>>::may_pass(stage, work, 0, work.part_count());
    for (; parts != 0U; parts &= parts - 1U) {
      MeetingTriangles candidate{};
      stage.list(work, static_cast<std::uint32_t>(std::countr_zero(parts)), candidate);
      stage.test_meeting(candidate, pairs);
    }
    return pairs.counts;
  }

 private:
  /// A volume from 0 to 1 along all axes, or 8 further.
  static Kdop18 place(int far) {
    Kdop18 volume{};
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      volume.lo[axis] = static_cast<float>(8 * far);
      volume.hi[axis] = static_cast<float>(8 * far + 1);
    }
    return volume;
  }

  CellScene scene_;
  Triangle corners_[kTriangles];
  std::uint32_t patches_[2 * kPatchSize] = {};
  PatchBounds<false> bounds_[2];
};

// Statement 27. A pair of patches becomes each pair of their triangles that meet, once: for all numbers of triangles,
// and all sets of those in the first that meet the second.
TEST(Patches, have_each_pair_of_their_triangles_once) {
  Enumeration patches(std::uint64_t{8} * 510);
  TwoPatches two;
  for (std::uint32_t n = 1; n <= kPatchSize; ++n) {
    for (std::uint32_t m = 1; m <= kPatchSize; ++m) {
      for (std::uint32_t near = 0; near < (1U << n); ++near) {
        two.set(n, m, near);
        std::map<std::uint64_t, int> expected;
        for (std::uint32_t i = 0; i < n; ++i) {
          for (std::uint32_t k = 0; k < m && (near >> i & 1U) != 0U; ++k) expected[pair_key(i, kPatchSize + k)] = 1;
        }
        ASSERT_EQ(two.expand(TwoPatches::kFirst, TwoPatches::kSecond), expected) << n << ' ' << m << ' ' << near;
        patches.next();
      }
    }
  }
}

// Statement 28. A patch and itself become each pair of two of its triangles that meet, once, and no triangle with
// itself.
TEST(Patches, have_each_pair_of_two_triangles_of_one_once) {
  Enumeration patches(510);
  TwoPatches two;
  for (std::uint32_t n = 1; n <= kPatchSize; ++n) {
    for (std::uint32_t near = 0; near < (1U << n); ++near) {
      two.set(n, 1, near);
      std::map<std::uint64_t, int> expected;
      for (std::uint32_t i = 0; i < n; ++i) {
        for (std::uint32_t k = i + 1; k < n; ++k) {
          if ((near >> i & 1U) == (near >> k & 1U)) expected[pair_key(i, k)] = 1;
        }
      }
      ASSERT_EQ(two.expand(TwoPatches::kFirst, TwoPatches::kFirst), expected) << n << ' ' << near;
      patches.next();
    }
  }
}

// Statement 29. A triangle and a patch become each pair of the triangle and one of the patch that meet, once.
TEST(Patches, have_each_pair_with_a_triangle_once) {
  Enumeration patches(510);
  TwoPatches two;
  for (std::uint32_t n = 1; n <= kPatchSize; ++n) {
    for (std::uint32_t near = 0; near < (1U << n); ++near) {
      two.set(n, 1, near);
      std::map<std::uint64_t, int> expected;
      for (std::uint32_t i = 0; i < n; ++i) {
        if ((near >> i & 1U) != 0U) expected[pair_key(i, TwoPatches::kSingle)] = 1;
      }
      ASSERT_EQ(two.expand(TwoPatches::kSingle, TwoPatches::kFirst), expected) << n << ' ' << near;
      patches.next();
    }
  }
}

}  // namespace
}  // namespace softcd::test
