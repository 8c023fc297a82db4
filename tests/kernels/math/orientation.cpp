#include "softcd/math/orientation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <set>

#include "random.hpp"
#include "softcd/math/perturbed_orientation.hpp"

// Compares signs of determinants with rational numbers.
namespace softcd::test {
namespace {

using Rational = boost::multiprecision::cpp_rational;

template <class T>
int reference(const Vec3<T> (&x)[4]) {
  Rational d[3][3];
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) d[row][axis] = Rational(x[row][axis]) - Rational(x[3][axis]);
  }
  const Rational volume = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                          d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                          d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return volume.sign();
}

Vec3f in_float(Vec3d p) {
  return vec3_cast<float>(p);
}

/// Makes four points of each kind in turn: anywhere, almost in a plane, on a grid, of very different sizes.
void make_points(Random& random, std::uint32_t kind, Vec3f (&x)[4]) {
  for (Vec3f& p : x) p = in_float(random.in_box(1.0));
  if (kind == 1) {
    const double u = random.uniform(-1, 2);
    const double v = random.uniform(-1, 2);
    x[3] =
        in_float((1.0 - u - v) * vec3_cast<double>(x[0]) + u * vec3_cast<double>(x[1]) + v * vec3_cast<double>(x[2]));
  } else if (kind == 2) {
    for (Vec3f& p : x) p = {std::round(3 * p.x), std::round(3 * p.y), std::round(3 * p.z)};
  } else if (kind == 3) {
    const auto size = [&] { return static_cast<float>(std::exp2(random.uniform(-149, 120))); };
    for (Vec3f& p : x) p = {size() * p.x, size() * p.y, size() * p.z};
    if (random.below(3) == 0) x[3] = x[random.below(3)];
  } else if (kind == 4) {
    const Vec3f corner{1024.0F, 512.0F, 2048.0F};
    const float step = std::numeric_limits<float>::epsilon() * 1024.0F;
    for (Vec3f& p : x) {
      p = {corner.x + std::round(4 * p.x) * step, corner.y + std::round(4 * p.y) * step,
           corner.z + std::round(4 * p.z) * step};
    }
  }
}

TEST(Orientation, is_the_exact_one) {
  Random random(8);
  int zeros = 0;
  for (std::uint32_t i = 0; i < 10000; ++i) {
    Vec3f x[4];
    make_points(random, i % 5, x);
    const int expected = reference(x);
    ASSERT_EQ(orientation(x[0], x[1], x[2], x[3]), expected) << "points " << i;
    ASSERT_EQ(orientation(x[1], x[0], x[2], x[3]), -expected) << "points " << i;
    ASSERT_EQ(detail::exact_orientation(x[0], x[1], x[2], x[3]), expected) << "points " << i;
    zeros += expected == 0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 400);
}

// Points in a plane up to the rounding of double, and then some that are moved by far less.
TEST(Orientation, of_doubles_is_the_exact_one) {
  Random random(9);
  int zeros = 0;
  for (int i = 0; i < 4000; ++i) {
    Vec3d x[4];
    for (Vec3d& p : x) p = random.in_box(1.0);
    const double u = random.uniform(-1, 2);
    const double v = random.uniform(-1, 2);
    x[3] = (1.0 - u - v) * x[0] + u * x[1] + v * x[2];
    if (i % 2 == 0) {
      for (Vec3d& p : x) p = {std::round(3 * p.x), std::round(3 * p.y), std::round(3 * p.z)};
    }
    if (i % 3 == 0) x[random.below(4)].x += std::exp2(random.uniform(-300, -40));
    const int expected = reference(x);
    ASSERT_EQ(orientation(x[0], x[1], x[2], x[3]), expected) << "points " << i;
    ASSERT_EQ(orientation(x[1], x[0], x[2], x[3]), -expected) << "points " << i;
    zeros += expected == 0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 100);
}

TEST(Orientation, is_exact_at_the_ends_of_floats_range) {
  constexpr float kLeast = std::numeric_limits<float>::denorm_min();
  constexpr float kMost = std::numeric_limits<float>::max();
  const Vec3f cases[][4] = {{{kLeast, 0, 0}, {0, kLeast, 0}, {0, 0, kLeast}, {0, 0, 0}},
                            {{kMost, 0, 0}, {0, kMost, 0}, {0, 0, kMost}, {-kMost, -kMost, -kMost}},
                            {{kMost, kMost, 1}, {-kMost, -kMost, 1}, {kMost, -kMost, 1}, {0, 0, 1}},
                            {{kMost, kMost, 1}, {-kMost, -kMost, 1}, {kMost, -kMost, 1 + 0x1p-23F}, {kLeast, 0, 1}}};
  for (const auto& x : cases) EXPECT_EQ(orientation(x[0], x[1], x[2], x[3]), reference(x));
  EXPECT_NE(orientation(cases[0][0], cases[0][1], cases[0][2], cases[0][3]), 0);
  EXPECT_NE(orientation(cases[3][0], cases[3][1], cases[3][2], cases[3][3]), 0);
}

/// A permutation of points negates the determinant or keeps it, also with infinitesimal motions.
TEST(PerturbedSide, changes_sign_with_the_order_of_points) {
  Random random(6);
  int perturbed = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    std::array<PerturbedPoint, 4> points;
    for (std::uint32_t p = 0; p < 4; ++p) {
      const auto coordinate = [&] { return static_cast<float>(random.below(2)); };
      points[p] = {{coordinate(), coordinate(), coordinate()}, static_cast<std::uint32_t>(random.below(2)), 3 - p};
    }
    const PerturbedSide side = perturbed_side(points[0], points[1], points[2], points[3]);
    ASSERT_EQ(std::abs(side.side), 1);
    perturbed += side.is_perturbed ? 1 : 0;
    const Vec3d x[4] = {points[0].x, points[1].x, points[2].x, points[3].x};
    ASSERT_EQ(side.is_perturbed, reference(x) == 0);
    if (!side.is_perturbed) {
      ASSERT_EQ(side.side, reference(x));
    }
    std::array<std::size_t, 4> order = {0, 1, 2, 3};
    do {
      int swaps = 0;
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = a + 1; b < 4; ++b) swaps += order[a] > order[b] ? 1 : 0;
      }
      const PerturbedSide other =
          perturbed_side(points[order[0]], points[order[1]], points[order[2]], points[order[3]]);
      ASSERT_EQ(other.side, swaps % 2 == 0 ? side.side : -side.side);
    } while (std::next_permutation(order.begin(), order.end()));
  }
  EXPECT_GT(perturbed, 1000);
}

/// A body that touches another one's plane is moved as a whole.
TEST(PerturbedSide, is_the_same_for_all_vertices_of_a_body_in_a_plane_of_another) {
  const PerturbedPoint corners[3] = {{{0, 0, 0}, 1, 0}, {{4, 0, 0}, 1, 1}, {{0, 4, 0}, 1, 2}};
  std::set<int> sides;
  for (std::uint32_t v = 0; v < 16; ++v) {
    const std::uint32_t row = v / 4;
    const Vec3d x = {double(v % 4), double(row), 0};
    sides.insert(perturbed_side(corners[0], corners[1], corners[2], {x, 5, v}).side);
  }
  EXPECT_EQ(sides.size(), 1U);
}

}  // namespace
}  // namespace softcd::test
