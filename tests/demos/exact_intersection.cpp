#include "mesh_tools/exact_intersection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "exact_ccd.hpp"

namespace softcd::test {
namespace {

using mesh_tools::intersects;
using Triangle3 = std::array<Vec3d, 3>;

constexpr Triangle3 kTriangle = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
constexpr double kTiny = std::numeric_limits<double>::denorm_min();

// Returns the result for every order of the triangle's corners and both orders of the segment's ends, which must agree.
bool intersects_always(Vec3d p, Vec3d q, Triangle3 t) {
  const bool first = intersects(p, q, t);
  for (int i = 0; i < 3; ++i) {
    for (int flip = 0; flip < 2; ++flip) {
      EXPECT_EQ(intersects(p, q, t), first);
      EXPECT_EQ(intersects(q, p, t), first);
      std::swap(t[0], t[1]);
    }
    std::rotate(t.begin(), t.begin() + 1, t.end());
  }
  return first;
}

TEST(ExactIntersection, through_the_inside_an_edge_or_a_corner) {
  EXPECT_TRUE(intersects_always({1, 1, 1}, {1, 1, -1}, kTriangle));
  EXPECT_TRUE(intersects_always({2, 0, 1}, {2, 0, -1}, kTriangle));
  EXPECT_TRUE(intersects_always({4, 0, 1}, {4, 0, -1}, kTriangle));
  EXPECT_FALSE(intersects_always({3, 3, 1}, {3, 3, -1}, kTriangle));
  EXPECT_FALSE(intersects_always({1, 1, 2}, {1, 1, 1}, kTriangle));
}

TEST(ExactIntersection, touching_counts_and_the_smallest_gap_does_not) {
  EXPECT_TRUE(intersects_always({1, 1, 0}, {1, 1, 5}, kTriangle));
  EXPECT_FALSE(intersects_always({1, 1, kTiny}, {1, 1, 5}, kTriangle));
  EXPECT_TRUE(intersects_always({2, 2, 1}, {2, 2, -1}, kTriangle)) << "on the long edge";
  const double outside = std::nextafter(2.0, 3.0);
  EXPECT_FALSE(intersects_always({2, outside, 1}, {2, outside, -1}, kTriangle));
  EXPECT_FALSE(intersects_always({-kTiny, 1, 1}, {-kTiny, 1, -1}, kTriangle));
}

TEST(ExactIntersection, coplanar_segments) {
  EXPECT_TRUE(intersects_always({1, 1, 0}, {1.5, 1, 0}, kTriangle)) << "inside";
  EXPECT_TRUE(intersects_always({-1, 1, 0}, {9, 1, 0}, kTriangle)) << "across";
  EXPECT_TRUE(intersects_always({-1, 0, 0}, {9, 0, 0}, kTriangle)) << "along an edge";
  EXPECT_TRUE(intersects_always({4, 0, 0}, {9, 0, 0}, kTriangle)) << "from a corner on";
  EXPECT_TRUE(intersects_always({4, -4, 0}, {4, 9, 0}, kTriangle)) << "past a corner";
  EXPECT_FALSE(intersects_always({5, 0, 0}, {9, 0, 0}, kTriangle));
  EXPECT_FALSE(intersects_always({3, 3, 0}, {9, 9, 0}, kTriangle));
  // The plane x + y + z = 1.
  const Triangle3 tilted = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_TRUE(intersects_always({0.25, 0.25, 0.5}, {2, 2, -3}, tilted));
  EXPECT_FALSE(intersects_always({1.25, -0.5, 0.25}, {2, 2, -3}, tilted));
}

TEST(ExactIntersection, degenerate_triangles_are_segments_and_points) {
  const Triangle3 needle = {{{0, 0, 0}, {4, 4, 4}, {1, 1, 1}}};
  EXPECT_TRUE(intersects_always({2, 2, 0}, {2, 2, 9}, needle));
  EXPECT_TRUE(intersects_always({3, 3, 3}, {9, 9, 9}, needle));
  EXPECT_FALSE(intersects_always({5, 5, 5}, {9, 9, 9}, needle));
  EXPECT_FALSE(intersects_always({2, 3, 0}, {2, 3, 9}, needle));
  EXPECT_FALSE(intersects_always({2, 0, 0}, {2, 1, 9}, needle)) << "skew";
  const Triangle3 point = {{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}};
  EXPECT_TRUE(intersects_always({0, 0, 0}, {2, 4, 6}, point));
  EXPECT_FALSE(intersects_always({0, 0, 0}, {2, 4, 7}, point));
}

TEST(ExactIntersection, degenerate_segments_are_points) {
  EXPECT_TRUE(intersects_always({1, 1, 0}, {1, 1, 0}, kTriangle));
  EXPECT_TRUE(intersects_always({2, 2, 0}, {2, 2, 0}, kTriangle));
  EXPECT_FALSE(intersects_always({1, 1, kTiny}, {1, 1, kTiny}, kTriangle));
  EXPECT_FALSE(intersects_always({3, 3, 0}, {3, 3, 0}, kTriangle));
}

// A segment's end that moves from p to q meets the triangle where the segment does. The exact test of motions, with
// other arithmetic, must agree. Coordinates are on a coarse grid, so that many are touching, coplanar or degenerate.
TEST(ExactIntersection, agrees_with_the_exact_test_of_motions) {
  std::mt19937 random(1);
  int hits = 0;
  for (const double scale : {1.0, 1e-3 / 3}) {
    std::uniform_int_distribution<int> coordinate(-2, 2);
    const auto point = [&] {
      return Vec3d{scale * coordinate(random), scale * coordinate(random), scale * coordinate(random)};
    };
    for (int i = 0; i < 3000; ++i) {
      const Vec3d p = point();
      const Vec3d q = point();
      const Triangle3 t = {point(), point(), point()};
      const std::array<Vec3d, 8> rows = {p, t[0], t[1], t[2], q, t[0], t[1], t[2]};
      const bool expected = collides_vertex_triangle(rows);
      hits += expected;
      ASSERT_EQ(intersects(p, q, t), expected) << "case " << i << " at scale " << scale;
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_LT(hits, 5500);
}

}  // namespace
}  // namespace softcd::test
