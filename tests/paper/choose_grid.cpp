#include "paper/choose_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "random.hpp"
#include "softcd/core/team.hpp"

namespace softcd::paper {
namespace {

using test::Random;

struct Sizes {
  std::vector<std::uint32_t> radius = std::vector<std::uint32_t>(kSizeBins, 0);
  std::vector<std::uint32_t> swept = std::vector<std::uint32_t>(kSizeBins, 0);

  /// Adds a triangle of radius r, with a path of radius s.
  void add(double r, double s) {
    ++radius[size_bin(static_cast<float>(r))];
    ++swept[size_bin(static_cast<float>(s))];
  }

  GridParameters choose(bool subdivision, float cell_size_factor) const {
    GridParameters grid{};
    SerialTeam team;
    const std::vector<std::uint32_t> near(kSizeBins, 0);
    ChooseGrid{
        {radius.data(), swept.data(), swept.data(), near.data(), radius.data()}, subdivision, cell_size_factor, &grid}(
        team);
    return grid;
  }
};

Sizes ordinary() {
  Random random(1);
  Sizes sizes;
  for (int i = 0; i < 5000; ++i) {
    const double r = random.uniform(0.5, 1.5);
    sizes.add(r, 2.0 * r);
  }
  return sizes;
}

TEST(PaperGrid, cell_is_three_factors_of_the_mean_way) {
  const Sizes sizes = ordinary();
  for (const float factor : {1.1F, 1.2F, 1.3F}) {
    const GridParameters grid = sizes.choose(true, factor);
    EXPECT_NEAR(grid.mean_radius, 2.0F, 0.3F);
    EXPECT_FLOAT_EQ(grid.cell_size, 3.0F * factor * grid.mean_radius);
    EXPECT_FLOAT_EQ(grid.inverse_cell_size, 1.0F / grid.cell_size);
  }
  EXPECT_EQ(sizes.choose(true, 0.0F).cell_size, sizes.choose(true, 1.2F).cell_size);
}

TEST(PaperGrid, cell_fits_the_largest_without_subdivision) {
  Sizes sizes = ordinary();
  sizes.add(20.0, 25.0);
  const float size = sizes.choose(false, 1.2F).cell_size;
  EXPECT_GE(size, 3.0F * 25.0F);
  EXPECT_LE(size, 3.0F * 25.0F * 1.26F);
}

TEST(PaperGrid, is_finite_whatever_comes) {
  Sizes nothing;
  Sizes points;
  points.add(0.0, 0.0);
  Sizes infinite;
  for (int i = 0; i < 3; ++i) infinite.add(INFINITY, INFINITY);
  for (const Sizes* sizes : {&nothing, &points, &infinite}) {
    for (const bool subdivision : {false, true}) {
      const GridParameters grid = sizes->choose(subdivision, 0.0F);
      EXPECT_TRUE(std::isfinite(grid.cell_size) && grid.cell_size > 0.0F);
      EXPECT_TRUE(std::isfinite(grid.inverse_cell_size) && grid.inverse_cell_size > 0.0F);
    }
  }
}

}  // namespace
}  // namespace softcd::paper
