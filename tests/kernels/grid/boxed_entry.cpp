#include "softcd/grid/boxed_entry.hpp"

#include <gtest/gtest.h>

#include "random.hpp"

namespace softcd::test {
namespace {

constexpr Entry kEntry{7, 9};

struct MovingBox {
  EndVolumes::Axis bounds[3];
};

/// Returns a box that contains, at one end of the step at least, a point of the cell from 0 to `size` shifted by
/// `corner`.
MovingBox random_box(Random& random, double corner, double size) {
  MovingBox box{};
  for (EndVolumes::Axis& axis : box.bounds) {
    const double inside = corner + size * random.unit();
    const double motion = size * random.uniform(-3.0, 3.0);
    const double extent = size * random.uniform(0.0, 1.5);
    const double lo = inside - extent * random.unit();
    axis.t0_lo = static_cast<float>(lo);
    axis.t0_hi = static_cast<float>(lo + extent);
    axis.t1_lo = static_cast<float>(lo + motion);
    axis.t1_hi = static_cast<float>(lo + motion + extent * random.uniform(0.5, 2.0));
  }
  return box;
}

/// Returns whether one is more than `gap` beyond the other along x, y or z at both ends.
bool are_apart(const MovingBox& a, const MovingBox& b, float gap) {
  for (int i = 0; i < 3; ++i) {
    const EndVolumes::Axis on_a = a.bounds[i];
    const EndVolumes::Axis on_b = b.bounds[i];
    if (on_a.t0_hi + gap < on_b.t0_lo && on_a.t1_hi + gap < on_b.t1_lo) return true;
    if (on_b.t0_hi + gap < on_a.t0_lo && on_b.t1_hi + gap < on_a.t1_lo) return true;
  }
  return false;
}

TEST(BoxedEntries, are_apart_where_their_boxes_are_by_a_step) {
  Random random(1);
  int apart = 0;
  int together = 0;
  for (int round = 0; round < 100000; ++round) {
    const float size = random.chance(0.5) ? 1.0F : 0.013F;
    const int cell = static_cast<int>(random.below(2001)) - 1000;
    const double corner = static_cast<double>(size) * cell;
    const MovingBox a = random_box(random, corner, static_cast<double>(size));
    const MovingBox b = random_box(random, corner, static_cast<double>(size));
    const std::uint32_t index = cell_index({cell, cell, cell});
    const bool said = boxes_certainly_apart<true>(boxed<true>(a.bounds, index, 1.0F / size, kEntry),
                                                  boxed<true>(b.bounds, index, 1.0F / size, kEntry));
    if (said) {
      ASSERT_TRUE(are_apart(a, b, 0.0F)) << round;
    } else {
      ASSERT_FALSE(are_apart(a, b, 1.01F * size / (1 << kBoxStepBits))) << round;
    }
    ++(said ? apart : together);
  }
  EXPECT_GT(apart, 10000);
  EXPECT_GT(together, 10000);
}

TEST(BoxedEntries, are_never_apart_where_their_boxes_are_not_however_far_and_large) {
  Random random(2);
  int apart = 0;
  for (int round = 0; round < 100000; ++round) {
    const int cell = static_cast<int>(random.below(1U << 20)) - (1 << 19);
    const double corner = static_cast<double>(cell);
    MovingBox a = random_box(random, corner, 1.0);
    const MovingBox b = random_box(random, corner, 1.0);
    EndVolumes::Axis& axis = a.bounds[random.below(3)];
    axis.t0_lo -= static_cast<float>(random.uniform(0.0, 100.0));
    axis.t1_hi = axis.t1_lo + static_cast<float>(random.uniform(0.0, 100.0));
    const std::uint32_t index = cell_index({cell, cell, cell});
    const bool said = boxes_certainly_apart<true>(boxed<true>(a.bounds, index, 1.0F, kEntry),
                                                  boxed<true>(b.bounds, index, 1.0F, kEntry));
    if (said) {
      ASSERT_TRUE(are_apart(a, b, 0.0F)) << round;
    }
    apart += said ? 1 : 0;
  }
  EXPECT_GT(apart, 5000);
}

/// Returns the volume of a triangle with some corners in the cell at `corner` and some far away.
Kdop18 random_volume(Random& random, double corner) {
  const double extent = random.chance(0.1) ? 100.0 : 1.5;
  const Vec3d first = Vec3d{corner, corner, corner} + Vec3d{random.unit(), random.unit(), random.unit()};
  Kdop18 volume = empty_kdop();
  extend(volume, vec3_cast<float>(first));
  extend(volume, vec3_cast<float>(first + random.in_box(extent)));
  extend(volume, vec3_cast<float>(first + random.in_box(extent)));
  return volume;
}

BoxedEntry at_rest(const Kdop18& volume, std::uint32_t index) {
  BoxedBounds bounds;
  for (int i = 0; i < 3; ++i) bounds[i] = {volume.lo[i], volume.hi[i], volume.lo[3 + i], volume.hi[3 + i]};
  return boxed<false>(bounds, index, 1.0F, kEntry);
}

/// Returns whether one is more than `gap` beyond the other along one of `axes`.
bool are_apart(const Kdop18& a, const Kdop18& b, int axes, float gap) {
  bool is_apart = false;
  for (int i = 0; i < axes; ++i) is_apart |= a.hi[i] + gap < b.lo[i] || b.hi[i] + gap < a.lo[i];
  return is_apart;
}

TEST(BoxedEntries, at_rest_are_apart_where_their_volumes_are_by_a_step) {
  Random random(3);
  int straight = 0;
  int diagonal = 0;
  int together = 0;
  for (int round = 0; round < 100000; ++round) {
    const int cell = static_cast<int>(random.below(2001)) - 1000;
    const Kdop18 a = random_volume(random, cell);
    const Kdop18 b = random_volume(random, cell);
    const std::uint32_t index = cell_index({cell, cell, cell});
    if (boxes_certainly_apart<false>(at_rest(a, index), at_rest(b, index))) {
      ASSERT_TRUE(are_apart(a, b, 6, 0.0F)) << round;
      ++(are_apart(a, b, 3, 0.0F) ? straight : diagonal);
    } else {
      ASSERT_FALSE(are_apart(a, b, 6, 1.01F / (1 << kBoxStepBits))) << round;
      ++together;
    }
  }
  EXPECT_GT(straight, 10000);
  EXPECT_GT(diagonal, 1000);
  EXPECT_GT(together, 10000);
}

TEST(BoxedEntries, keep_triangle_and_bits) {
  const MovingBox box{};
  const BoxedEntry entry = boxed<true>(box.bounds, 0, 1.0F, kEntry);
  EXPECT_EQ(entry.entry().root, kEntry.root);
  EXPECT_EQ(entry.entry().bits, kEntry.bits);
}

}  // namespace
}  // namespace softcd::test
