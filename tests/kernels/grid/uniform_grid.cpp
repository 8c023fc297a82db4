#include "softcd/grid/uniform_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "grid/random_cells.hpp"
#include "random.hpp"
#include "softcd/stages/cell_assignment.hpp"

namespace softcd::test {
namespace {

TEST(UniformGrid, fractions_round_down) {
  const Cell cell = cell_of({-0.25F, 0.25F, -1.0F}, 1.0F);
  EXPECT_EQ(cell.x, -1);
  EXPECT_EQ(cell.y, 0);
  EXPECT_EQ(cell.z, -1);
}

TEST(IntegerDop, row_is_what_nine_intervals_leave) {
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    const IntegerDop dop = random_integer_dop(random, 5);
    std::set<std::tuple<int, int, int>> expected;
    for (int z = -9; z <= 9; ++z) {
      for (int y = -9; y <= 9; ++y) {
        for (int x = -9; x <= 9; ++x) {
          const bool inside = is_member(dop, {x, y, z});
          ASSERT_EQ(dop.contains({x, y, z}), inside);
          ASSERT_EQ(dop.row(y, z).contains(x), inside);
          if (!inside) continue;
          expected.insert({x, y, z});
          ASSERT_TRUE(dop.column(z).contains(y));
        }
      }
    }
    std::set<std::tuple<int, int, int>> visited;
    for_each_cell(dop, [&](Cell c) {
      const CellInterval row = dop.row(c.y, c.z);
      EXPECT_TRUE(visited.insert({c.x, c.y, c.z}).second) << "visited twice";
      EXPECT_TRUE(row.contains(c.x));
    });
    ASSERT_EQ(visited, expected);
  }
}

TEST(IntegerDop, span_is_the_longest_side) {
  IntegerDop dop{};
  dop.hi[0] = 1;
  dop.lo[1] = -4;
  dop.hi[2] = 2;
  EXPECT_EQ(dop.span(), 5);
}

/// Returns the cell of a real point, by the monotone rule that the detector uses for coordinates.
Cell cell_of_real(const long double (&p)[3], float inverse_size) {
  int cell[3];
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<int>(std::floor(static_cast<float>(p[axis] * static_cast<long double>(inverse_size))));
  }
  return {cell[0], cell[1], cell[2]};
}

// Triangles that share a point therefore share that point's cell.
TEST(IntegerDop, contains_the_cells_of_the_points_of_a_triangle) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const double offset = std::ldexp(1.0, static_cast<int>(random.below(16)));
    const auto inverse_size = static_cast<float>(random.uniform(0.3, 8.0));
    const Vec3d centre = random.in_box(offset);
    Vec3f v[3];
    Kdop18 dop = empty_kdop();
    for (Vec3f& corner : v) {
      corner = vec3_cast<float>(centre + random.in_box(2.0));
      if (random.chance(0.3)) corner.x = std::floor(corner.x * inverse_size) / inverse_size;
      if (random.chance(0.3)) corner.y = corner.x;
      extend(dop, corner);
    }
    ASSERT_TRUE(within_grid(dop, inverse_size));
    const IntegerDop cells = integer_dop(dop, inverse_size);
    for (int k = 0; k < 8; ++k) {
      long double w[3] = {0.0L, 0.0L, 0.0L};
      if (k < 3) {
        w[k] = 1.0L;
      } else {
        w[0] = random.unit();
        w[1] = (1.0L - w[0]) * random.unit();
        w[2] = 1.0L - w[0] - w[1];
      }
      long double p[3] = {0.0L, 0.0L, 0.0L};
      for (int corner = 0; corner < 3; ++corner) {
        for (int axis = 0; axis < 3; ++axis) p[axis] += w[corner] * static_cast<long double>(v[corner][axis]);
      }
      ASSERT_TRUE(cells.contains(cell_of_real(p, inverse_size))) << "triangle " << i << ", point " << k;
    }
  }
}

TEST(IntegerDop, is_not_much_larger_than_the_triangle) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const Vec3d centre = random.in_box(100.0);
    Kdop18 dop = empty_kdop();
    for (int corner = 0; corner < 3; ++corner) extend(dop, vec3_cast<float>(centre + random.in_box(0.45)));
    ASSERT_LE(integer_dop(dop, 1.0F).span(), 2);
  }
}

TEST(UniformGrid, reach_ends_where_integers_do) {
  Kdop18 dop = empty_kdop();
  extend(dop, {kGridExtent, -kGridExtent, 0.0F});
  EXPECT_TRUE(within_grid(dop, 1.0F));
  EXPECT_FALSE(within_grid(dop, 1.1F));
  extend(dop, {0.0F, 0.0F, 1e30F});
  EXPECT_FALSE(within_grid(dop, 1.0F));
}

}  // namespace
}  // namespace softcd::test
