#include "softcd/math/scalar.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random.hpp"

namespace softcd::test {
namespace {

TEST(RoundedDown, is_the_largest_float_that_is_not_above) {
  Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const double x = random.chance(0.5) ? random.unit() : std::pow(10.0, random.uniform(-44.0, 38.0));
    const float down = rounded_down(x);
    ASSERT_LE(static_cast<double>(down), x);
    ASSERT_GT(static_cast<double>(std::nextafter(down, INFINITY)), x);
  }
  EXPECT_EQ(rounded_down(0.0), 0.0F);
  EXPECT_EQ(rounded_down(1e-60), 0.0F);
  EXPECT_EQ(rounded_down(1.0), 1.0F);
  EXPECT_EQ(rounded_down(std::nextafter(1.0, 0.0)), std::nextafter(1.0F, 0.0F));
  EXPECT_EQ(rounded_down(0.1F), 0.1F);
}

TEST(Length, is_right_where_squares_are_not) {
  for (int exponent = -126; exponent <= 124; ++exponent) {
    const float unit = std::ldexp(1.0F, exponent);
    EXPECT_EQ(length(Vec3f{2 * unit, -unit, 2 * unit}), 3 * unit) << exponent;
  }
  EXPECT_EQ(length(Vec3f{0, 0, 0}), 0.0F);
}

}  // namespace
}  // namespace softcd::test
