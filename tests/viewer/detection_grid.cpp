#include "viewer/detection_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "grid_scenes.hpp"
#include "lower_neighbour.hpp"
#include "softcd/grid/control_bits.hpp"

namespace softcd::demo {
namespace {

using test::Mesh;
using test::Scene;

Scene folded_cloths() {
  const Mesh cloth = test::crumpled_cloth(40, 30, 0.1, 0.08, 3);
  const Mesh ball = test::moved(test::icosphere(3, 0.7), {1, 0.5, 0.4});
  return {test::moving(cloth, test::translated(cloth.positions, {0.02, 0.01, -0.03}), test::everything(0.01F)),
          test::moving(ball, test::jittered(ball.positions, 0.05, 4), test::everything(0.02F))};
}

// Far from the origin, without self collision: triangles out of their partners' reach stay out of the grid.
Scene far_away_pair() {
  const Mesh cloth = test::moved(test::grid_cloth(30, 30, 0.1), {1000, -2000, 500});
  const Mesh other = test::moved(cloth, {1.5, 0.3, 0.02});
  BodySettings settings = test::everything(0.03F);
  settings.self_collision = false;
  return {test::still(cloth, settings), test::still(other, settings)};
}

struct Case {
  const char* name;
  Scene (*scene)();
  PipelineOptions options;
};

PipelineOptions with_motion_margin() {
  PipelineOptions options = on_cpu(Detection::dcd);
  options.motion_margin = 2;
  return options;
}

PipelineOptions uniform() {
  PipelineOptions options = on_cpu(Detection::ccd);
  options.broad_phase = BroadPhase::uniform;
  return options;
}

PipelineOptions slab() {
  PipelineOptions options = on_cpu(Detection::dcd);
  options.contact_rule = ContactRule::slab;
  options.cell_size_factor = 2.2F;
  return options;
}

class DetectionGridOf : public testing::TestWithParam<Case> {};

TEST_P(DetectionGridOf, counts_what_the_detector_counts) {
  const Scene scene = GetParam().scene();
  const DetectionGrid grid(grid_bodies(scene), GetParam().options);
  test::LoadedScene loaded = test::load(scene, GetParam().options);
  loaded.pipeline.detect();
  const Statistics& expected = loaded.pipeline.query.statistics();
  const Statistics& counts = grid.counts();
  EXPECT_GT(counts.tests, 0U);
  EXPECT_EQ(counts.triangle_pairs, expected.triangle_pairs);
  EXPECT_EQ(counts.active_triangles, expected.active_triangles);
  // On the CPU the detector's own `exact` grid has patches.
  if (GetParam().options.broad_phase == BroadPhase::exact) return;
  EXPECT_EQ(counts.cell_size, expected.cell_size);
  EXPECT_EQ(counts.split_triangles, expected.split_triangles);
  EXPECT_EQ(counts.children, expected.children);
  EXPECT_EQ(counts.big_triangles, expected.big_triangles);
  EXPECT_EQ(counts.entries, expected.entries);
  EXPECT_EQ(counts.cells, expected.cells);
  EXPECT_EQ(counts.tests, expected.tests);
}

TEST_P(DetectionGridOf, cells_hold_all_entries_and_tests) {
  const DetectionGrid grid(grid_bodies(GetParam().scene()), GetParam().options);
  std::uint64_t entries = 0;
  std::uint64_t tests = 0;
  for (const OccupiedCell& cell : grid.cells()) {
    EXPECT_GT(cell.entry_count, 0U);
    EXPECT_EQ(cell.first_entry, entries);
    entries += cell.entry_count;
    tests += cell.tests;
  }
  EXPECT_EQ(grid.cells().size(), grid.counts().cells);
  EXPECT_EQ(entries, grid.counts().entries);
  EXPECT_EQ(tests + grid.counts().big_triangles * grid.counts().active_triangles, grid.counts().tests);
}

bool is_in(const OccupiedCell& cell, double size, Vec3d point) {
  const double tolerance = 1e-3 * size;
  const Vec3d from_low = point - cell.low;
  const auto fits = [&](double x) { return x >= -tolerance && x <= size + tolerance; };
  return fits(from_low.x) && fits(from_low.y) && fits(from_low.z);
}

// A triangle is registered in every cell that it is in, also in the cell of its centroid.
TEST_P(DetectionGridOf, triangles_lie_in_their_cells) {
  const Scene scene = GetParam().scene();
  const DetectionGrid grid(grid_bodies(scene), GetParam().options);
  std::size_t found = 0;
  for (std::size_t b = 0; b < scene.size(); ++b) {
    for (std::uint32_t t = 0; t < scene[b].triangles.size(); t += 7) {
      const std::uint32_t triangle = grid.first_triangle(b) + t;
      EXPECT_EQ(grid.body_of(triangle), b);
      const std::vector<const OccupiedCell*> cells = grid.cells_of(triangle);
      if (cells.empty()) continue;  // out of reach, or one of the big
      Vec3d centroid{0, 0, 0};
      for (const std::uint32_t v : scene[b].triangles[t].v) centroid = centroid + (1.0 / 3) * scene[b].x_t1[v];
      const OccupiedCell* around = grid.cell_around(triangle);
      ASSERT_NE(around, nullptr);
      EXPECT_NE(std::find(cells.begin(), cells.end(), around), cells.end());
      // If the grid wraps around, a cell is drawn at its first entry.
      if (is_in(*around, grid.cell_size(), centroid)) ++found;
    }
  }
  EXPECT_GT(found, 50U);
}

TEST_P(DetectionGridOf, masks_say_which_neighbours_hold_the_triangle) {
  const DetectionGrid grid(grid_bodies(GetParam().scene()), GetParam().options);
  const std::uint32_t triangle = grid.first_triangle(0) + 5;
  const std::vector<const OccupiedCell*> cells = grid.cells_of(triangle);
  for (const OccupiedCell* cell : cells) {
    for (const GridEntry& entry : grid.entries(*cell)) {
      if (entry.triangle != triangle) continue;
      const Cell place = cell_near(cell->index, {0, 0, 0});
      for (std::uint32_t bit = 0; bit < kMaskBits; ++bit) {
        const std::uint32_t neighbour = cell_index(test::lower_neighbour(place, static_cast<int>(bit)));
        const bool is_there = std::any_of(cells.begin(), cells.end(),
                                          [&](const OccupiedCell* other) { return other->index == neighbour; });
        EXPECT_EQ(((entry.mask >> bit) & 1U) != 0, is_there);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DetectionGridOf,
                         testing::Values(Case{"FoldedClothsDcd", folded_cloths, on_cpu(Detection::dcd)},
                                         Case{"FoldedClothsCcd", folded_cloths, on_cpu(Detection::ccd)},
                                         Case{"FoldedClothsMotion", folded_cloths, with_motion_margin()},
                                         Case{"FoldedClothsUniform", folded_cloths, uniform()},
                                         Case{"FoldedClothsSlab", folded_cloths, slab()},
                                         Case{"UnevenSoupCcd", uneven_soup, on_cpu(Detection::ccd)},
                                         Case{"FarAwayPair", far_away_pair, on_cpu(Detection::dcd)}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(DetectionGrid, children_tile_the_triangle) {
  const Scene scene = uneven_soup();
  const DetectionGrid grid(grid_bodies(scene), on_cpu(Detection::ccd));
  std::uint64_t children = 0;
  std::uint64_t split = 0;
  const auto triangle_count = static_cast<std::uint32_t>(scene[0].triangles.size() + scene[1].triangles.size());
  for (std::uint32_t t = 0; t < triangle_count; ++t) {
    const std::vector<DetectionGrid::Corners> parts = grid.children_of(t);
    if (parts.empty()) continue;
    ++split;
    children += parts.size();
    const std::size_t b = grid.body_of(t);
    const Triangle& triangle = scene[b].triangles[t - grid.first_triangle(b)];
    const auto& x = scene[b].x_t1;
    const auto area = [](Vec3d p, Vec3d q, Vec3d r) { return 0.5 * std::sqrt(squared_norm(cross(q - p, r - p))); };
    double sum = 0;
    for (const auto& [p, q, r] : parts) sum += area(p, q, r);
    EXPECT_NEAR(sum, area(x[triangle.v[0]], x[triangle.v[1]], x[triangle.v[2]]), 1e-4);
  }
  EXPECT_GT(split, 0U);
  EXPECT_EQ(split, grid.counts().split_triangles);
  EXPECT_EQ(children, grid.counts().children);
}

}  // namespace
}  // namespace softcd::demo
