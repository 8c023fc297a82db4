#include "softcd/math/pseudo_normal.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random.hpp"

namespace softcd::test {
namespace {

TEST(PseudoNormal, angles_are_right_up_to_half_a_turn) {
  constexpr double kPi = 3.141592653589793;
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const Vec3d a = random.direction();
    const double angle = random.uniform(0.0, kPi);
    const Vec3d across = unit_vector(cross(a, random.direction()));
    const Vec3d b = std::cos(angle) * a + std::sin(angle) * across;
    ASSERT_NEAR(angle_between(2.0 * a, 0.5 * b), angle, 1e-12) << i;
    ASSERT_NEAR(angle_between(a, -2.0 * a), kPi, 1e-12) << i;
  }
}

}  // namespace
}  // namespace softcd::test
