#include "box_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "random.hpp"

namespace softcd::test {
namespace {

std::vector<IndexPair> by_brute_force(const std::vector<Box>& boxes) {
  std::vector<IndexPair> pairs;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    for (std::uint32_t j = i + 1; j < boxes.size(); ++j) {
      const bool is_empty = boxes[i].lo.x > boxes[i].hi.x || boxes[j].lo.x > boxes[j].hi.x;
      if (!is_empty && overlap(boxes[i], boxes[j])) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

Box box_around(Vec3d centre, Vec3d half) {
  return {vec3_cast<float>(centre - half), vec3_cast<float>(centre + half)};
}

std::vector<Box> scattered_boxes(std::uint32_t count, Vec3d extent, double half) {
  Random random(count);
  std::vector<Box> boxes;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3d at = random.in_box(1.0);
    const Vec3d size = random.in_box(half);
    boxes.push_back(box_around({at.x * extent.x, at.y * extent.y, at.z * extent.z},
                               {std::abs(size.x), std::abs(size.y), std::abs(size.z)}));
  }
  return boxes;
}

TEST(BoxPairs, are_those_of_brute_force) {
  for (const std::uint32_t count : {0U, 1U, 2U, 4U, 5U, 9U, 100U, 1000U}) {
    EXPECT_EQ(overlapping_pairs(scattered_boxes(count, {1, 1, 1}, 0.2)),
              by_brute_force(scattered_boxes(count, {1, 1, 1}, 0.2)));
    EXPECT_EQ(overlapping_pairs(scattered_boxes(count, {0, 30, 0}, 0.2)),
              by_brute_force(scattered_boxes(count, {0, 30, 0}, 0.2)));
  }
}

TEST(BoxPairs, include_equal_touching_and_endless_boxes_but_no_empty_ones) {
  constexpr float kInfinity = HUGE_VALF;
  std::vector<Box> boxes = scattered_boxes(60, {1, 1, 1}, 0.2);
  for (int i = 0; i < 20; ++i) boxes.push_back(box_around({2, 0, 0}, {1, 1, 1}));
  boxes.push_back(box_around({4, 0, 0}, {1, 1, 1}));
  for (int i = 0; i < 2; ++i) {
    boxes.push_back({{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}});
    boxes.push_back({{3e38F, 3e38F, 3e38F}, {-3e38F, -3e38F, -3e38F}});
  }
  const std::vector<IndexPair> pairs = overlapping_pairs(boxes);
  EXPECT_EQ(pairs, by_brute_force(boxes));
  EXPECT_GT(pairs.size(), 190U + 20U + 80U);
}

// Each overlaps all others along two axes: a sweep along one of those would compare all of them.
TEST(BoxPairs, of_a_long_row_are_few) {
  std::vector<Box> boxes;
  for (std::uint32_t i = 0; i < 50000; ++i) boxes.push_back(box_around({0, 0, 1.0 * i}, {5, 5, 0.5}));
  const std::vector<IndexPair> pairs = overlapping_pairs(boxes);
  ASSERT_EQ(pairs.size(), 49999U);
  for (std::uint32_t i = 0; i < pairs.size(); ++i) ASSERT_EQ(pairs[i], IndexPair(i, i + 1));
}

}  // namespace
}  // namespace softcd::test
