#include "softcd/stages/virtual_subdivision.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "random.hpp"
#include "softcd/stages/grid_parameters.hpp"

namespace softcd::test {
namespace {

/// The (row, along) of the three corners; exact in double.
using Child = std::array<std::array<double, 2>, 3>;

Child child(int level, std::uint32_t index) {
  const ChildWeights weights = child_weights(level, index);
  Child c{};
  for (int corner = 0; corner < 3; ++corner) {
    c[corner] = {static_cast<double>(weights.row[corner]), static_cast<double>(weights.along[corner])};
  }
  return c;
}

double signed_area(const Child& c) {
  return 0.5 * ((c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]));
}

bool contains(const Child& c, double row, double along) {
  const std::array<double, 2> p{row, along};
  int signs[2] = {0, 0};
  for (int i = 0; i < 3; ++i) {
    const double area = signed_area({c[i], c[(i + 1) % 3], p});
    if (area > 0.0) ++signs[0];
    if (area < 0.0) ++signs[1];
  }
  return signs[0] == 0 || signs[1] == 0;
}

// In (row, along) the parent is the triangle 0 <= along <= row <= 1 of area 1/2.
TEST(VirtualSubdivision, children_tile_the_parent) {
  Random random(1);
  for (int level = 0; level <= kMaxLevel; ++level) {
    const std::uint32_t count = 1U << (2 * level);
    double area = 0.0;
    std::set<Child> distinct;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Child c = child(level, i);
      EXPECT_TRUE(distinct.insert(c).second);
      EXPECT_DOUBLE_EQ(std::abs(signed_area(c)), 0.5 / count);
      area += std::abs(signed_area(c));
      for (const auto& [row, along] : c) {
        EXPECT_TRUE(0.0 <= along && along <= row && row <= 1.0);
        EXPECT_EQ(std::ldexp(row, level), std::floor(std::ldexp(row, level)));
        EXPECT_EQ(std::ldexp(along, level), std::floor(std::ldexp(along, level)));
      }
    }
    EXPECT_DOUBLE_EQ(area, 0.5);
    for (int sample = 0; sample < 200; ++sample) {
      const double row = std::sqrt(random.unit());
      const double along = row * random.unit();
      int holders = 0;
      for (std::uint32_t i = 0; i < count; ++i) holders += contains(child(level, i), row, along) ? 1 : 0;
      EXPECT_GE(holders, 1) << "level " << level << ": " << row << ", " << along;
    }
  }
}

TEST(VirtualSubdivision, level_zero_is_the_triangle) {
  const TriangleMotion parent{{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}}, {{0, 0, 1}, {2, 0, 1}, {0, 2, 1}}};
  const TriangleMotion whole = child_motion(parent, 0, 0);
  for (int corner = 0; corner < 3; ++corner) {
    EXPECT_EQ(whole.t0[corner], parent.t0[corner]);
    EXPECT_EQ(whole.t1[corner], parent.t1[corner]);
  }
}

TEST(VirtualSubdivision, a_child_is_half_as_large_per_level) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const int level = 1 + static_cast<int>(random.below(kMaxLevel));
    TriangleMotion parent{};
    for (int corner = 0; corner < 3; ++corner) {
      parent.t0[corner] = vec3_cast<float>(random.in_box(4.0));
      parent.t1[corner] = vec3_cast<float>(random.in_box(4.0));
    }
    const TriangleMotion part = child_motion(parent, level, random.below(1U << (2 * level)));
    for (int side = 0; side < 3; ++side) {
      const Vec3f of_part = part.t0[(side + 1) % 3] - part.t0[side];
      float closest = INFINITY;
      for (int other = 0; other < 3; ++other) {
        const Vec3f of_parent = std::ldexp(1.0F, -level) * (parent.t0[(other + 1) % 3] - parent.t0[other]);
        closest = std::min({closest, max_norm(of_part - of_parent), max_norm(of_part + of_parent)});
      }
      ASSERT_LT(closest, 1e-5F);
    }
  }
}

// Every point of the moving triangle is, at all times, within the volume of its child.
TEST(VirtualSubdivision, volumes_of_children_cover_the_moving_triangle) {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const int level = 1 + static_cast<int>(random.below(4));
    const double offset = std::ldexp(1.0, static_cast<int>(random.below(14)));
    const auto growth = static_cast<float>(random.chance(0.5) ? 0.0 : 0.01 * random.unit());
    const Vec3d centre = random.in_box(offset);
    TriangleMotion parent{};
    for (int corner = 0; corner < 3; ++corner) {
      parent.t0[corner] = vec3_cast<float>(centre + random.in_box(3.0));
      parent.t1[corner] = vec3_cast<float>(centre + random.in_box(3.0));
    }
    const std::uint32_t count = 1U << (2 * level);
    for (int sample = 0; sample < 50; ++sample) {
      const double row = std::sqrt(random.unit());
      const double along = row * random.unit();
      const double time = random.unit();
      Vec3d p{0, 0, 0};
      const double weights[3] = {1.0 - row, row - along, along};
      for (int corner = 0; corner < 3; ++corner) {
        p = p +
            weights[corner] * lerp(vec3_cast<double>(parent.t0[corner]), vec3_cast<double>(parent.t1[corner]), time);
      }
      const Vec3d grown = p + (0.999 * static_cast<double>(growth)) * random.direction();
      const double projections[kKdopAxes] = {grown.x,           grown.y,           grown.z,
                                             grown.x + grown.y, grown.x + grown.z, grown.y + grown.z,
                                             grown.x - grown.y, grown.x - grown.z, grown.y - grown.z};
      bool held = false;
      for (std::uint32_t k = 0; k < count && !held; ++k) {
        if (!contains(child(level, k), row, along)) continue;
        const Kdop18 volume = child_volume(parent, level, k, growth);
        held = true;
        for (int axis = 0; axis < kKdopAxes; ++axis) {
          held = held && volume.lo[axis] <= projections[axis] && projections[axis] <= volume.hi[axis];
        }
      }
      ASSERT_TRUE(held) << "triangle " << i << ", level " << level;
    }
  }
}

// Corners lie far to either side of 0. Between them, children's corners are hardly larger than the rounding of their
// sums.
TEST(VirtualSubdivision, volumes_of_children_cover_corners_that_are_near_0) {
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const int level = 1 + static_cast<int>(random.below(kMaxLevel));
    TriangleMotion motion{};
    for (int corner = 0; corner < 3; ++corner) {
      const double side = corner == 0 ? -1000.0 : 1000.0;
      motion.t0[corner] = vec3_cast<float>(Vec3d{side, side, side} + random.in_box(1.0));
      motion.t1[corner] = motion.t0[corner];
    }
    const std::uint32_t row = 1U << (level - 1);
    const std::uint32_t index = row * row + random.below(2 * row + 1);
    const Child corners = child(level, index);
    const Kdop18 volume = child_volume(motion, level, index, 0.0F);
    for (const auto& [down, along] : corners) {
      const Vec3d x[3] = {vec3_cast<double>(motion.t0[0]), vec3_cast<double>(motion.t0[1]),
                          vec3_cast<double>(motion.t0[2])};
      const Vec3d p = (1.0 - down) * x[0] + (down - along) * x[1] + along * x[2];
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_LE(static_cast<double>(volume.lo[axis]), p[axis]) << i;
        ASSERT_GE(static_cast<double>(volume.hi[axis]), p[axis]) << i;
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test
