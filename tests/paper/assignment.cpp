#include "paper/assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"

namespace softcd::paper {
namespace {

using test::grid_of;
using test::HostScene;
using test::Mesh;
using test::Random;

/// Returns corners as (row, along), which are multiples of 2^-level.
std::set<std::array<float, 2>> corners_of(int level, std::uint32_t child) {
  const ChildWeights weights = child_weights(level, child);
  std::set<std::array<float, 2>> corners;
  for (int i = 0; i < 3; ++i) corners.insert({weights.row[i], weights.along[i]});
  return corners;
}

/// Returns the child of the level above whose area contains the centre of this one.
std::uint32_t parent_of(int level, std::uint32_t child) {
  float row = 0.0F;
  float along = 0.0F;
  for (const auto& [r, a] : corners_of(level, child)) {
    row += r / 3.0F;
    along += a / 3.0F;
  }
  const auto scale = static_cast<float>(1U << (level - 1));
  const auto parent_row = static_cast<std::uint32_t>(row * scale);
  const auto column = static_cast<std::uint32_t>(along * scale);
  const float within_row = row * scale - static_cast<float>(parent_row);
  const float within_column = along * scale - static_cast<float>(column);
  return parent_row * parent_row + 2 * column + (within_column > within_row ? 1U : 0U);
}

TEST(Siblings, are_the_other_children_of_the_same_parent) {
  for (std::uint16_t level = 1; level <= 4; ++level) {
    for (const std::uint16_t halvings : {std::uint16_t{0}, std::uint16_t{2}}) {
      const Split root{0, level, halvings};
      for (std::uint32_t child = 0; child < root.child_count(); ++child) {
        std::set<std::uint32_t> siblings;
        for_each_sibling(root, child, [&](std::uint32_t sibling) { siblings.insert(sibling); });
        std::set<std::uint32_t> expected;
        for (std::uint32_t other = 0; other < root.child_count(); ++other) {
          const bool same_slab = (other & ((1U << halvings) - 1U)) == (child & ((1U << halvings) - 1U));
          if (other != child && same_slab &&
              parent_of(level, other >> halvings) == parent_of(level, child >> halvings)) {
            expected.insert(other);
          }
        }
        ASSERT_EQ(expected.size(), 3U);
        ASSERT_EQ(siblings, expected) << "level " << level << ", child " << child;
      }
    }
  }
}

TEST(Siblings, a_whole_triangle_has_none) {
  for_each_sibling(Split{0, 0, 0}, 0, [](std::uint32_t) { ADD_FAILURE(); });
}

TEST(SphereCells, are_those_within_the_radius) {
  Random random(1);
  const GridParameters grid = grid_of(0.75F);
  for (int i = 0; i < 20000; ++i) {
    const Vec3d centre = random.in_box(10.0);
    const Sphere sphere{vec3_cast<float>(centre), static_cast<float>(random.uniform(0.0, 0.25))};
    std::set<std::uint32_t> cells;
    for_each_cell(sphere, grid, [&](Cell cell) { EXPECT_TRUE(cells.insert(Control::cell_index(cell)).second); });
    ASSERT_LE(cells.size(), 8U) << "a third of a cell reaches 2 x 2 x 2 at most";
    ASSERT_TRUE(cells.contains(Control::cell_index(cell_of(sphere.centre, grid.inverse_cell_size))));
    for (int k = 0; k < 10; ++k) {
      const Vec3d p =
          vec3_cast<double>(sphere.centre) + (0.999 * static_cast<double>(sphere.radius)) * random.direction();
      ASSERT_TRUE(cells.contains(Control::cell_index(cell_of(vec3_cast<float>(p), grid.inverse_cell_size))));
    }
  }
}

// A child's sphere holds its part of the triangle in its part of the step.
TEST(ChildSphere, holds_the_child) {
  Random random(2);
  const Mesh mesh{{{{0, 1, 2}}}, {{0, 0, 0}, {8, 1, 0}, {2, 7, 3}}};
  const HostScene host({{mesh, {{1, 1, -4}, {7, 2, 5}, {3, 9, 1}}}}, true);
  const SceneView scene = host.view();
  const TriangleMotion parent = load_triangle(scene, 0);
  const Split root{0, 2, 2};
  for (std::uint32_t child = 0; child < root.child_count(); ++child) {
    const Sphere sphere = child_sphere(scene, root, child, 0.125F);
    const TriangleMotion motion = child_motion(parent, root.level, child >> root.halvings);
    for (int sample = 0; sample < 50; ++sample) {
      const double time = 0.25 * ((child & 3U) + random.unit());
      const double u = random.unit();
      const double w[3] = {u, (1.0 - u) * random.unit(), 0.0};
      Vec3d p = 0.124 * random.direction();
      for (int i = 0; i < 3; ++i) {
        const double weight = i == 2 ? 1.0 - w[0] - w[1] : w[i];
        p = p + weight * lerp(vec3_cast<double>(motion.t0[i]), vec3_cast<double>(motion.t1[i]), time);
      }
      ASSERT_LE(std::sqrt(squared_norm(p - vec3_cast<double>(sphere.centre))), static_cast<double>(sphere.radius));
    }
  }
}

TEST(Control, a_pair_at_home_in_one_cell_is_tested_there) {
  for (std::uint32_t type = 0; type < 8; ++type) {
    const std::uint32_t cell = Control::cell_index(
        {static_cast<int>(type & 1U), static_cast<int>((type >> 1) & 1U), static_cast<int>((type >> 2) & 1U)});
    EXPECT_EQ(Control::type_of(cell), type);
    const Entry a{0, Control::pack(type, 255, 0)};
    const Entry b{1, Control::pack(type, 255, 0)};
    EXPECT_NE(Control::judge(cell, a, b), Verdict::skip);
    const Entry phantom{2, Control::pack(type ^ 7U, 255, 0)};
    EXPECT_EQ(Control::judge(cell, phantom, phantom), Verdict::skip);
  }
}

// Two whole triangles with different homes, which both touch both homes, are tested in one of the two.
TEST(Control, two_homes_make_one_test) {
  for (std::uint32_t home_a = 0; home_a < 8; ++home_a) {
    for (std::uint32_t home_b = 0; home_b < 8; ++home_b) {
      const std::uint32_t both = (1U << home_a) | (1U << home_b);
      const Entry a{0, Control::pack(home_a, both, 0)};
      const Entry b{1, Control::pack(home_b, both, 0)};
      std::set<std::uint32_t> tested;
      for (const std::uint32_t type : {home_a, home_b}) {
        const std::uint32_t cell = Control::cell_index(
            {static_cast<int>(type & 1U), static_cast<int>((type >> 1) & 1U), static_cast<int>((type >> 2) & 1U)});
        if (Control::judge(cell, a, b) != Verdict::skip) tested.insert(type);
      }
      EXPECT_EQ(tested, std::set<std::uint32_t>{std::min(home_a, home_b)});
    }
  }
}

}  // namespace
}  // namespace softcd::paper
