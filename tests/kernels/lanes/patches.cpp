#include "lanes/patches.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

#include "each_target.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

/// Returns bounds of few values, so that they touch; some triangles share vertices, some have no volume.
template <bool kSwept>
PatchBounds<kSwept> random_bounds(Random& random) {
  PatchBounds<kSwept> bounds{};
  for (std::uint32_t i = 0; i < kPatchSize; ++i) {
    const bool is_empty = random.chance(0.1);
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      for (int end = 0; end < PatchBounds<kSwept>::kEnds; ++end) {
        const float lo = static_cast<float>(random.below(12));
        bounds.lo[axis][end][i] = is_empty ? FLT_MAX : lo;
        bounds.hi[axis][end][i] = is_empty ? -FLT_MAX : lo + static_cast<float>(3 + random.below(9));
      }
    }
    for (int corner = 0; corner < 3; ++corner) bounds.v[corner][i] = random.below(40);
    bounds.set_owned(i, random.below(3) == 0 ? 0U : random.below(64));
  }
  return bounds;
}

template <bool kSwept>
cpu::StraightBounds random_box(Random& random) {
  cpu::StraightBounds box{};
  for (EndVolumes::Axis& axis : box.axes) {
    const auto t0 = static_cast<float>(random.below(12));
    const float t1 = kSwept ? static_cast<float>(random.below(12)) : t0;
    axis = {t0, t0 + 3, t1, t1 + 3};
  }
  return box;
}

template <bool kSwept>
void expect_as_one_by_one() {
  Random random(2);
  int meeting = 0;
  int pairs = 0;
  int meeting_box = 0;
  for (int round = 0; round < 4000; ++round) {
    const PatchBounds<kSwept> a = random_bounds<kSwept>(random);
    const PatchBounds<kSwept> b = random_bounds<kSwept>(random);
    const std::uint32_t rows = random.below(1U << kPatchSize);
    const cpu::StraightBounds box = random_box<kSwept>(random);
    const std::uint32_t rows_at_box = cpu::rows_that_meet(a, box);
    ASSERT_EQ(rows_at_box, cpu::generic::rows_that_meet<kSwept>(a, box));
    meeting_box += std::popcount(rows_at_box);
    for (const bool leaves_neighbours : {false, true}) {
      const std::uint64_t bits = cpu::triangles_that_meet(a, rows, b, leaves_neighbours);
      ASSERT_EQ(bits, cpu::generic::triangles_that_meet<kSwept>(a, rows, b, leaves_neighbours)) << "rows " << rows;
      meeting += std::popcount(bits);
      pairs += static_cast<int>(kPatchSize) * std::popcount(rows);
    }
  }
  EXPECT_GT(meeting, pairs / 50);
  EXPECT_LT(meeting, pairs - pairs / 50);
  EXPECT_GT(meeting_box, 2000);
  EXPECT_LT(meeting_box, 30000);
}

void expect_that_the_same_move_past() {
  Random random(3);
  int past = 0;
  int pairs = 0;
  for (int round = 0; round < 4000; ++round) {
    const PatchBounds<true> a = random_bounds<true>(random);
    const PatchBounds<true> b = random_bounds<true>(random);
    const std::uint64_t meeting = cpu::triangles_that_meet(a, 255U, b, false);
    const std::uint64_t bits = cpu::triangles_that_move_past(a, meeting, b);
    ASSERT_EQ(bits, cpu::generic::triangles_that_move_past(a, meeting, b));
    past += std::popcount(bits);
    pairs += std::popcount(meeting);
  }
  EXPECT_GT(past, 100);
  EXPECT_LT(past, pairs - 100);
}

TEST(PatchesInLanes, answer_as_one_by_one) {
  for_each_target([] {
    expect_as_one_by_one<true>();
    expect_as_one_by_one<false>();
    expect_that_the_same_move_past();
  });
}

}  // namespace
}  // namespace softcd::test
