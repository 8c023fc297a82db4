#include "softcd/math/kdop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <vector>

#include "random.hpp"

namespace softcd::test {
namespace {

constexpr long double kNormals[kKdopAxes][3] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1},  {1, 1, 0}, {1, 0, 1},
                                                {0, 1, 1}, {1, -1, 0}, {1, 0, -1}, {0, 1, -1}};

/// Returns the projection, exact for float coordinates whose exponents differ by less than 40.
long double projection(Vec3f p, int axis) {
  return kNormals[axis][0] * static_cast<long double>(p.x) + kNormals[axis][1] * static_cast<long double>(p.y) +
         kNormals[axis][2] * static_cast<long double>(p.z);
}

struct Interval {
  long double low = INFINITY;
  long double high = -INFINITY;
};

Interval exact_interval(const std::vector<Vec3f>& points, int axis) {
  Interval interval;
  for (const Vec3f& p : points) {
    interval.low = std::min(interval.low, projection(p, axis));
    interval.high = std::max(interval.high, projection(p, axis));
  }
  return interval;
}

Kdop18 volume_of(const std::vector<Vec3f>& points) {
  Kdop18 dop = empty_kdop();
  for (const Vec3f& p : points) extend(dop, p);
  return dop;
}

/// Returns the largest gap along an axis; negative where all intervals overlap.
long double largest_gap(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b, long double radius) {
  long double gap = -INFINITY;
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    const Interval of_a = exact_interval(a, axis);
    const Interval of_b = exact_interval(b, axis);
    const long double scale = axis < 3 ? 1.0L : std::sqrt(2.0L);
    gap = std::max({gap, (of_b.low - of_a.high) - scale * radius, (of_a.low - of_b.high) - scale * radius});
  }
  return gap;
}

std::vector<Vec3f> random_triangle(Random& random, double offset, double size) {
  const Vec3d centre = random.in_box(offset);
  std::vector<Vec3f> corners(3);
  for (Vec3f& corner : corners) corner = vec3_cast<float>(centre + random.in_box(size));
  return corners;
}

/// Moves b so that its interval on a random axis begins where a's ends, up to a few roundings.
void bring_into_touch(const std::vector<Vec3f>& a, std::vector<Vec3f>& b, Random& random) {
  const int axis = static_cast<int>(random.below(kKdopAxes));
  const long double move = exact_interval(a, axis).high - exact_interval(b, axis).low;
  const int along = kNormals[axis][0] != 0.0L ? 0 : (kNormals[axis][1] != 0.0L ? 1 : 2);
  for (Vec3f& p : b) {
    float* coordinate = along == 0 ? &p.x : (along == 1 ? &p.y : &p.z);
    *coordinate = static_cast<float>(static_cast<long double>(*coordinate) + move);
  }
}

TEST(Kdop, volumes_overlap_when_the_exact_ones_do) {
  Random random(1);
  int overlapping = 0;
  int apart = 0;
  for (int i = 0; i < 300000; ++i) {
    const double offset = std::ldexp(1.0, static_cast<int>(random.below(12)));
    const std::vector<Vec3f> a = random_triangle(random, offset, 1.0);
    std::vector<Vec3f> b = random_triangle(random, 0.0, 1.0);
    for (Vec3f& p : b) p = p + a[0];
    if (random.chance(0.7)) bring_into_touch(a, b, random);
    const long double gap = largest_gap(a, b, 0.0L);
    const bool found = overlap(volume_of(a), volume_of(b));
    if (gap <= 0.0L) {
      ++overlapping;
      ASSERT_TRUE(found) << "pair " << i;
    }
    if (gap > 4.0L * FLT_EPSILON * (offset + 4.0L)) {
      ++apart;
      ASSERT_FALSE(found) << "pair " << i;
    }
  }
  EXPECT_GT(overlapping, 50000);
  EXPECT_GT(apart, 50000);
}

TEST(Kdop, inflated_volumes_overlap_when_the_exact_ones_do) {
  Random random(2);
  int overlapping = 0;
  int apart = 0;
  for (int i = 0; i < 300000; ++i) {
    const double offset = std::ldexp(1.0, static_cast<int>(random.below(12)));
    const std::vector<Vec3f> a = random_triangle(random, offset, 1.0);
    std::vector<Vec3f> b = random_triangle(random, 0.0, 1.0);
    for (Vec3f& p : b) p = p + a[0];
    const auto radius_a = static_cast<float>(random.uniform(0.0, 0.1));
    const auto radius_b = static_cast<float>(random.uniform(0.0, 0.1));
    const long double radius = static_cast<long double>(radius_a) + static_cast<long double>(radius_b);
    bring_into_touch(a, b, random);
    const int shifted_axis = static_cast<int>(random.below(3));
    for (Vec3f& p : b) {
      float* coordinate = shifted_axis == 0 ? &p.x : (shifted_axis == 1 ? &p.y : &p.z);
      *coordinate += static_cast<float>(radius);
    }
    Kdop18 dop_a = volume_of(a);
    Kdop18 dop_b = volume_of(b);
    inflate(dop_a, radius_a);
    inflate(dop_b, radius_b);
    const long double gap = largest_gap(a, b, radius);
    if (gap <= 0.0L) {
      ++overlapping;
      ASSERT_TRUE(overlap(dop_a, dop_b)) << "pair " << i;
    }
    // Either volume's diagonals carry 8 epsilon of the largest coordinate for the roundings of the points' projections.
    if (gap > 32.0L * FLT_EPSILON * (offset + 4.0L)) {
      ++apart;
      ASSERT_FALSE(overlap(dop_a, dop_b)) << "pair " << i;
    }
  }
  EXPECT_GT(overlapping, 10000);
  EXPECT_GT(apart, 10000);
}

TEST(Kdop, empty_volume_overlaps_nothing) {
  Kdop18 everything = volume_of({{-1e30F, -1e30F, -1e30F}, {1e30F, 1e30F, 1e30F}});
  Kdop18 empty = empty_kdop();
  EXPECT_TRUE(is_empty(empty));
  EXPECT_FALSE(is_empty(everything));
  EXPECT_FALSE(overlap(empty, everything));
  EXPECT_FALSE(overlap(empty, empty));
  inflate(empty, 1.0F);
  EXPECT_TRUE(is_empty(empty));
}

TEST(Kdop, zero_radius_changes_nothing) {
  const Kdop18 before = volume_of({{1.0F, 2.0F, 3.0F}});
  Kdop18 after = before;
  inflate(after, 0.0F);
  EXPECT_TRUE(std::equal(before.lo, before.lo + kKdopAxes, after.lo));
  EXPECT_TRUE(std::equal(before.hi, before.hi + kKdopAxes, after.hi));
}

TEST(Kdop, outward_passes_one_rounding) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const auto x =
        static_cast<float>(random.uniform(-1.0, 1.0) * std::ldexp(1.0, static_cast<int>(random.below(200)) - 100));
    ASSERT_LE(outward_down(x), std::nextafterf(x, -INFINITY));
    ASSERT_GE(outward_up(x), std::nextafterf(x, INFINITY));
    ASSERT_GE(outward_down(x), x - 3.0F * (std::nextafterf(std::abs(x), INFINITY) - std::abs(x)) - FLT_MIN);
  }
  EXPECT_LT(outward_down(0.0F), 0.0F);
  EXPECT_GT(outward_up(0.0F), 0.0F);
}

TEST(Kdop, boxes) {
  const Box a = merged(box_of(Vec3f{0, 0, 0}), box_of(Vec3f{1, 2, 3}));
  EXPECT_TRUE(overlap(a, box_of(Vec3f{1, 2, 3})));
  EXPECT_FALSE(overlap(a, box_of(Vec3f{1, 2, 3.0001F})));
  EXPECT_TRUE(overlap(inflated(a, 0.5F), box_of(Vec3f{-0.5F, 2.5F, 3.5F})));
  EXPECT_FALSE(overlap(inflated(a, 0.5F), box_of(Vec3f{-0.51F, 2.5F, 3.5F})));
  EXPECT_TRUE(overlap(a, volume_of({{-1, -1, -1}, {0, 0, 0}})));
  EXPECT_FALSE(overlap(a, volume_of({{-1, -1, -1}, {-0.1F, 0, 0}})));
}

}  // namespace
}  // namespace softcd::test
