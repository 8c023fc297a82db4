#include "box_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "random.hpp"

namespace softcd::test {
namespace {

std::vector<IndexPair> by_brute_force(const std::vector<Box>& boxes, const std::vector<std::uint32_t>& groups = {}) {
  std::vector<IndexPair> pairs;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    for (std::uint32_t j = i + 1; j < boxes.size(); ++j) {
      const bool is_empty = boxes[i].lo.x > boxes[i].hi.x || boxes[j].lo.x > boxes[j].hi.x;
      const bool are_apart = !groups.empty() && groups[i] != groups[j];
      if (!is_empty && !are_apart && overlap(boxes[i], boxes[j])) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

std::vector<IndexPair> found_by(BoxPairs& finder, const std::vector<Box>& boxes,
                                const std::vector<std::uint32_t>& groups = {}) {
  const Span<const IndexPair> pairs = finder.find(boxes, groups);
  return {pairs.begin(), pairs.end()};
}

std::vector<IndexPair> overlapping_pairs(const std::vector<Box>& boxes) {
  BoxPairs finder;
  return found_by(finder, boxes);
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

void move(std::vector<Box>& boxes, double furthest, Random& random) {
  for (Box& box : boxes) {
    const Vec3f way = vec3_cast<float>(random.in_box(furthest));
    box = {box.lo + way, box.hi + way};
  }
}

// The previous call's tree is wrong for all of these boxes.
TEST(BoxPairs, are_found_again_wherever_boxes_have_gone) {
  for (const std::uint32_t count : {3U, 40U, 900U}) {
    Random random(count);
    BoxPairs finder;
    std::vector<Box> boxes = scattered_boxes(count, {1, 1, 1}, 0.1);
    for (int step = 0; step < 30; ++step) {
      const double furthest = step % 7 == 6 ? 3.0 : 0.02;
      move(boxes, furthest, random);
      if (step % 5 == 4) std::swap(boxes[random.below(count)], boxes[random.below(count)]);
      if (step % 9 == 8) boxes.push_back(boxes[random.below(count)]);
      if (step % 11 == 10) boxes.erase(boxes.begin() + random.below(count));
      if (step % 13 == 12) std::swap(boxes[random.below(count)].lo, boxes[random.below(count)].hi);
      ASSERT_EQ(found_by(finder, boxes), by_brute_force(boxes)) << count << " boxes, step " << step;
    }
  }
}

TEST(BoxPairs, that_were_empty_are_found_once_they_are_not) {
  const Box empty = {{3e38F, 3e38F, 3e38F}, {-3e38F, -3e38F, -3e38F}};
  const std::vector<Box> all = scattered_boxes(100, {1, 1, 1}, 0.3);
  BoxPairs finder;
  for (const std::size_t first : {0U, 1U, 50U, 99U, 0U}) {
    std::vector<Box> boxes = all;
    for (std::size_t i = first; i < boxes.size(); i += 2) boxes[i] = empty;
    ASSERT_EQ(found_by(finder, boxes), by_brute_force(boxes)) << first;
  }
  EXPECT_TRUE(found_by(finder, std::vector<Box>(100, empty)).empty());
  EXPECT_EQ(found_by(finder, all), by_brute_force(all));
  EXPECT_TRUE(found_by(finder, {}).empty());
}

TEST(BoxPairs, of_different_groups_are_none) {
  Random random(7);
  BoxPairs finder;
  std::vector<Box> boxes = scattered_boxes(700, {1, 1, 1}, 0.4);
  std::vector<std::uint32_t> groups(boxes.size(), 0);
  for (const std::uint32_t group_count : {1U, 2U, 9U, 300U, 4000000000U}) {
    for (std::uint32_t& group : groups) group = random.below(group_count);
    for (int step = 0; step < 3; ++step) {
      move(boxes, 0.05, random);
      ASSERT_EQ(found_by(finder, boxes, groups), by_brute_force(boxes, groups)) << group_count;
    }
    groups[5] = groups[6] = 17;
    ASSERT_EQ(found_by(finder, boxes, groups), by_brute_force(boxes, groups)) << group_count;
    ASSERT_EQ(found_by(finder, boxes), by_brute_force(boxes));
  }
}

// So many boxes are divided, and searched, by several threads.
TEST(BoxPairs, of_many_boxes_are_those_of_a_sweep) {
  BoxPairs finder;
  std::vector<Box> boxes = scattered_boxes(30000, {10, 10, 10}, 0.3);
  Random random(11);
  for (int step = 0; step < 3; ++step) {
    std::vector<std::uint32_t> by_x(boxes.size());
    std::iota(by_x.begin(), by_x.end(), 0U);
    std::sort(by_x.begin(), by_x.end(), [&](auto a, auto b) { return boxes[a].lo.x < boxes[b].lo.x; });
    std::vector<IndexPair> expected;
    for (std::size_t i = 0; i < by_x.size(); ++i) {
      for (std::size_t j = i + 1; j < by_x.size() && boxes[by_x[j]].lo.x <= boxes[by_x[i]].hi.x; ++j) {
        if (overlap(boxes[by_x[i]], boxes[by_x[j]])) expected.emplace_back(std::minmax(by_x[i], by_x[j]));
      }
    }
    std::sort(expected.begin(), expected.end());
    ASSERT_GT(expected.size(), step == 2 ? 0U : 5000U);
    ASSERT_EQ(found_by(finder, boxes), expected);
    move(boxes, step == 0 ? 0.05 : 5.0, random);
  }
}

}  // namespace
}  // namespace softcd::test
