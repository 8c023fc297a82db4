#include "softcd/mesh/vertex_stars.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "softcd/mesh/topology.hpp"

namespace softcd::test {
namespace {

/// Returns the ring of vertex 0's star, without kNoIndex. A ring may begin anywhere and run in either sense.
std::vector<std::uint32_t> ring_of(const std::vector<Triangle>& triangles) {
  const VertexStar star = star_of(0, triangles);
  EXPECT_EQ(star.centre, 0U);
  const auto* const end = std::find(std::begin(star.ring), std::end(star.ring), kNoIndex);
  EXPECT_TRUE(std::all_of(end, std::end(star.ring), [](std::uint32_t v) { return v == kNoIndex; }));
  return {std::begin(star.ring), end};
}

/// Expects the triangles to have the sides of the ring, each once.
void expect_fan(const std::vector<Triangle>& triangles, bool is_closed) {
  const std::vector<std::uint32_t> ring = ring_of(triangles);
  ASSERT_EQ(ring.size(), triangles.size() + 1);
  EXPECT_EQ(ring.front() == ring.back(), is_closed);
  std::vector<std::uint64_t> sides;
  std::vector<std::uint64_t> expected;
  for (std::size_t i = 0; i + 1 < ring.size(); ++i) sides.push_back(edge_key(ring[i], ring[i + 1]));
  for (const Triangle& t : triangles) {
    std::vector<std::uint32_t> outer(t.v, t.v + 3);
    outer.erase(std::find(outer.begin(), outer.end(), 0U));
    expected.push_back(edge_key(outer[0], outer[1]));
  }
  std::sort(sides.begin(), sides.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(sides, expected);
}

TEST(VertexStars, rings_follow_the_triangles) {
  expect_fan({{{0, 1, 2}}}, false);
  expect_fan({{{4, 0, 3}}, {{0, 1, 2}}, {{3, 2, 0}}}, false);
  expect_fan({{{1, 2, 0}}, {{0, 3, 1}}, {{2, 3, 0}}}, true);
  // Orientations differ.
  expect_fan({{{0, 1, 2}}, {{0, 3, 2}}, {{3, 0, 4}}, {{0, 4, 1}}}, true);
  std::vector<Triangle> eight;
  for (std::uint32_t i = 0; i < 8; ++i) eight.push_back({{i + 1, (i + 1) % 8 + 1, 0}});
  expect_fan(eight, true);
}

TEST(VertexStars, other_stars_have_no_ring) {
  EXPECT_TRUE(ring_of({}).empty());
  EXPECT_TRUE(ring_of({{{0, 1, 2}}, {{0, 3, 4}}}).empty()) << "two fans";
  EXPECT_TRUE(ring_of({{{0, 1, 2}}, {{0, 2, 3}}, {{0, 2, 4}}}).empty()) << "three triangles at an edge";
  EXPECT_TRUE(ring_of({{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{0, 1, 4}}}).empty())
      << "three at an edge, in one walk along all of them";
  EXPECT_TRUE(ring_of({{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{0, 4, 5}}, {{0, 5, 6}}, {{0, 6, 4}}}).empty())
      << "two closed fans";
  EXPECT_TRUE(ring_of({{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{0, 4, 5}}}).empty()) << "a closed fan and an open one";
  EXPECT_TRUE(ring_of({{{0, 1, 1}}}).empty()) << "a segment";
  EXPECT_TRUE(ring_of({{{0, 1, 2}}, {{0, 2, 0}}}).empty()) << "the centre twice";
  std::vector<Triangle> nine;
  for (std::uint32_t i = 0; i < 9; ++i) nine.push_back({{i + 1, (i + 1) % 9 + 1, 0}});
  EXPECT_TRUE(ring_of(nine).empty()) << "too many";
}

}  // namespace
}  // namespace softcd::test
