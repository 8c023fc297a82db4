#include "softcd/stages/grid_parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "random.hpp"
#include "softcd/core/team.hpp"

namespace softcd::test {
namespace {

struct Sizes {
  std::vector<std::uint32_t> radius = std::vector<std::uint32_t>(kSizeBins, 0);
  std::vector<std::uint32_t> swept = std::vector<std::uint32_t>(kSizeBins, 0);
  std::vector<std::uint32_t> extent = std::vector<std::uint32_t>(kSizeBins, 0);
  std::vector<std::uint32_t> distance = std::vector<std::uint32_t>(kSizeBins, 0);

  /// Adds a triangle of radius r, with a path of radius s, at distance d, with a margin.
  void add(double r, double s, double d, double margin = 0.0) {
    ++radius[size_bin(static_cast<float>(r + margin))];
    ++swept[size_bin(static_cast<float>(s + margin))];
    ++extent[size_bin(cell_extent(static_cast<float>(s), static_cast<float>(margin)))];
    ++distance[size_bin(static_cast<float>(d))];
  }

  GridParameters choose(BroadPhase broad_phase, bool subdivision = true, float cell_size_factor = 0.0F) const {
    GridParameters grid{};
    SerialTeam team;
    ChooseGrid{{radius.data(), swept.data(), extent.data(), distance.data(), radius.data()},
               broad_phase,
               subdivision,
               cell_size_factor,
               &grid}(team);
    return grid;
  }
};

Sizes ordinary() {
  Random random(1);
  Sizes sizes;
  for (int i = 0; i < 5000; ++i) {
    const double r = random.uniform(0.5, 1.5);
    sizes.add(r, r, random.uniform(0.0, 50.0));
  }
  return sizes;
}

TEST(ChooseGrid, cell_is_factor_times_mean) {
  const Sizes sizes = ordinary();
  for (const float factor : {0.8F, 1.2F, 1.8F, 2.4F}) {
    const GridParameters grid = sizes.choose(BroadPhase::exact, true, factor);
    EXPECT_NEAR(grid.mean_radius, 1.0F, 0.15F);
    EXPECT_FLOAT_EQ(grid.cell_size, factor * grid.mean_radius);
    EXPECT_FLOAT_EQ(grid.inverse_cell_size, 1.0F / grid.cell_size);
  }
  EXPECT_EQ(sizes.choose(BroadPhase::exact).cell_size, sizes.choose(BroadPhase::exact, true, 1.8F).cell_size);
}

TEST(ChooseGrid, uniform_fits_the_largest) {
  Sizes sizes = ordinary();
  sizes.add(20.0, 25.0, 10.0);
  const float size = sizes.choose(BroadPhase::uniform).cell_size;
  EXPECT_GE(size, 3.0F * 25.0F);
  EXPECT_LE(size, 3.0F * 25.0F * 1.26F);
}

TEST(ChooseGrid, one_stray_triangle_changes_little) {
  Sizes sizes = ordinary();
  const float before = sizes.choose(BroadPhase::exact).cell_size;
  sizes.add(1e30, 1e30, 1e30);
  EXPECT_NEAR(sizes.choose(BroadPhase::exact).cell_size, before, 0.02F * before);
}

TEST(ChooseGrid, children_stay_within_their_budget) {
  Sizes sizes;
  for (int i = 0; i < 20000; ++i) sizes.add(i % 2 == 0 ? 0.01 : 0.6, 0.01, 1.0);
  const GridParameters grid = sizes.choose(BroadPhase::exact);
  const double children = 10000.0 * std::pow(4.0, split_level(0.75F, grid.cell_size));
  EXPECT_LE(children, 8.0 * 20000.0 + 65536.0);
}

TEST(ChooseGrid, cells_grow_with_what_most_triangles_sweep) {
  Sizes sizes;
  for (int i = 0; i < 20000; ++i) sizes.add(0.5, 5.0, 1.0);
  const float chosen = sizes.choose(BroadPhase::exact).cell_size;
  EXPECT_GT(chosen, 2.0F * 1.8F * 0.5F);
  EXPECT_LT(chosen, 5.0F);
  EXPECT_NEAR(sizes.choose(BroadPhase::exact, true, 1.8F).cell_size, 1.8F * 0.5F, 0.15F);
}

TEST(ChooseGrid, cells_grow_with_large_margins) {
  Sizes sizes;
  for (int i = 0; i < 20000; ++i) sizes.add(0.5, 0.5, 1.0, i % 10 == 0 ? 25.0 : 0.0);
  const float size = sizes.choose(BroadPhase::exact).cell_size;
  EXPECT_LE(2000.0 * 0.5 * std::pow(50.0 / double(size), 3), 10.0 * 20000.0);
  EXPECT_LT(size, 25.0F);
}

TEST(ChooseGrid, entries_of_fast_triangles_stay_within_their_budget) {
  Sizes sizes;
  for (int i = 0; i < 20000; ++i) sizes.add(0.5, i % 10 == 0 ? 50.0 : 0.5, 1.0);
  const double most = 20000.0 / double(kTestsPerCell);  // triangles that take more are tested against all
  for (const float factor : {0.0F, 0.2F, 0.8F, 1.8F}) {
    const double size = double(sizes.choose(BroadPhase::exact, true, factor).cell_size);
    const double cells = std::pow(2 / std::sqrt(3.0) * 50.0 / size, 3) / 8;
    EXPECT_LE(2000.0 * std::min(cells, most), 256.0 * 20000.0 + 65536.0) << factor;
  }
}

TEST(ChooseGrid, a_few_fast_triangles_change_little) {
  Sizes few;
  for (int i = 0; i < 20000; ++i) few.add(0.5, i % 1000 == 0 ? 5.0 : 0.5, 1.0);
  Sizes none;
  for (int i = 0; i < 20000; ++i) none.add(0.5, 0.5, 1.0);
  EXPECT_LT(few.choose(BroadPhase::exact).cell_size, 1.1F * none.choose(BroadPhase::exact).cell_size);
}

TEST(ChooseGrid, the_furthest_ordinary_triangle_is_within_reach) {
  Sizes sizes;
  for (int i = 0; i < 1000; ++i) sizes.add(1e-6, 1e-6, 1e4);
  EXPECT_GE(sizes.choose(BroadPhase::exact).cell_size * kGridExtent, 1e4F);
}

TEST(ChooseGrid, is_finite_whatever_comes) {
  Sizes nothing;
  Sizes points;
  points.add(0.0, 0.0, 0.0);
  Sizes infinite;
  for (int i = 0; i < 3; ++i) infinite.add(INFINITY, INFINITY, INFINITY);
  for (const Sizes* sizes : {&nothing, &points, &infinite}) {
    for (const BroadPhase broad_phase : {BroadPhase::exact, BroadPhase::uniform}) {
      const GridParameters grid = sizes->choose(broad_phase);
      EXPECT_TRUE(std::isfinite(grid.cell_size) && grid.cell_size > 0.0F);
      EXPECT_TRUE(std::isfinite(grid.inverse_cell_size) && grid.inverse_cell_size > 0.0F);
    }
  }
}

TEST(SplitLevel, leaves_whole_what_is_not_much_larger_than_a_cell) {
  EXPECT_EQ(split_level(kWholeSize, 1.0F), 0);
  EXPECT_EQ(split_level(1.001F * kWholeSize, 1.0F), subdivision_level(1.001F * kWholeSize, kChildSize));
  EXPECT_EQ(split_level(INFINITY, 1.0F), kMaxLevel + 1);
}

TEST(SubdivisionLevel, halves_until_it_fits) {
  EXPECT_EQ(subdivision_level(1.0F, 1.0F), 0);
  EXPECT_EQ(subdivision_level(1.001F, 1.0F), 1);
  EXPECT_EQ(subdivision_level(2.0F, 1.0F), 1);
  EXPECT_EQ(subdivision_level(2.001F, 1.0F), 2);
  EXPECT_EQ(subdivision_level(64.0F, 1.0F), kMaxLevel);
  EXPECT_EQ(subdivision_level(65.0F, 1.0F), kMaxLevel + 1);
  EXPECT_EQ(subdivision_level(INFINITY, 1.0F), kMaxLevel + 1);
  EXPECT_EQ(subdivision_level(0.0F, 1.0F), 0);
}

}  // namespace
}  // namespace softcd::test
