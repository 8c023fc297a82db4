#include "softcd/stages/lbvh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace softcd::test {
namespace {

// Triangle 1 has a vertex that is not finite, and leaf 3 has no triangle.
TEST(Lbvh, leaves_out_triangles_that_are_left_out) {
  const std::vector<Vec3f> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, NAN}, {0, 0, 1}};
  const std::vector<Triangle> triangles{{{0, 1, 2}}, {{1, 2, 3}}, {{0, 1, 4}}};
  const std::vector<Ownership> ownership{0, kLeftOut, 0};
  const std::vector<std::uint32_t> bodies{5, 6, 7};
  BvhInput input{};
  input.x = x.data();
  input.triangles = triangles.data();
  input.ownership = ownership.data();
  input.triangle_body = bodies.data();
  input.triangle_count = 3;
  input.bounds = {{0, 0, 0}, {1, 1, 1}};

  constexpr std::uint64_t kLast = (1ULL << kMortonBits) - 1;
  std::vector<std::uint64_t> keys(4);
  std::vector<std::uint32_t> order(4);
  std::vector<BvhLeaf> leaves(4);
  for (std::uint32_t i = 0; i < 4; ++i) KeyLeaf{input, keys.data(), order.data()}(i);
  for (std::uint32_t i = 0; i < 4; ++i) PlaceLeaf{input, order.data(), leaves.data()}(i);
  for (std::uint32_t i = 0; i < 4; ++i) {
    const bool is_there = i == 0 || i == 2;
    EXPECT_EQ(keys[i] < kLast, is_there) << i;
    EXPECT_EQ(leaves[i].triangle, is_there ? i : kNoIndex) << i;
    EXPECT_EQ(leaves[i].body, is_there ? bodies[i] : 0U) << i;
  }
}

}  // namespace
}  // namespace softcd::test
