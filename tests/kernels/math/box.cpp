#include "softcd/math/box.hpp"

#include <gtest/gtest.h>

#include "random.hpp"

namespace softcd::test {
namespace {

Vec3f random_point(Random& random) {
  return vec3_cast<float>(random.in_box(1.0));
}

// Sums of such floats are exact in double.
TEST(Box, that_is_inflated_contains_the_exact_one_on_all_sides) {
  Random random(1);
  int rounded[2][3] = {};
  for (int i = 0; i < 2000; ++i) {
    const Box box = merged(box_of(random_point(random)), box_of(random_point(random)));
    const auto radius = static_cast<float>(random.uniform(0.01, 1.0));
    const Box inflated_box = inflated(box, radius);
    for (int axis = 0; axis < 3; ++axis) {
      const double lo = static_cast<double>(box.lo[axis]) - static_cast<double>(radius);
      const double hi = static_cast<double>(box.hi[axis]) + static_cast<double>(radius);
      ASSERT_LE(static_cast<double>(inflated_box.lo[axis]), lo) << axis;
      ASSERT_GE(static_cast<double>(inflated_box.hi[axis]), hi) << axis;
      rounded[0][axis] += static_cast<double>(box.lo[axis] - radius) > lo ? 1 : 0;
      rounded[1][axis] += static_cast<double>(box.hi[axis] + radius) < hi ? 1 : 0;
    }
  }
  for (const auto& side : rounded) {
    for (const int count : side) EXPECT_GT(count, 200) << "too few sums are rounded inwards to show anything";
  }
}

TEST(Box, without_a_radius_stays_as_it_is) {
  const Box box{{-1, 2, 3}, {4, 5, 6}};
  for (const float radius : {0.0F, -1.0F}) {
    const Box same = inflated(box, radius);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(same.lo[axis], box.lo[axis]);
      EXPECT_EQ(same.hi[axis], box.hi[axis]);
    }
  }
}

}  // namespace
}  // namespace softcd::test
