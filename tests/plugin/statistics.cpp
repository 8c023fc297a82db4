#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

Scene uneven_scene(std::uint32_t count = 1000) {
  Scene scene;
  for (std::uint64_t i = 0; i < 2; ++i) {
    SoupOptions options;
    options.triangle_count = count;
    options.half_extent = 3.0;
    options.largest = 4.0;
    options.size_ratio = 200.0;
    options.joined_share = 0.3;
    options.seed = 80 + i;
    const Mesh mesh = triangle_soup(options);
    scene.push_back(moving(mesh, jittered(mesh.positions, 0.1, i), everything(0.01F)));
  }
  return scene;
}

Statistics statistics_of(const Scene& scene, const PipelineOptions& options) {
  LoadedScene loaded = load(scene, options);
  loaded.pipeline.detect();
  return loaded.pipeline.query.statistics();
}

class StatisticsOf : public testing::TestWithParam<Detection> {};

TEST_P(StatisticsOf, counts_match_the_contacts) {
  const Scene scene = uneven_scene();
  LoadedScene loaded = load(scene, test_options(GetParam()));
  const Span<const Contact> contacts = loaded.pipeline.detect();
  const Statistics& s = loaded.pipeline.query.statistics();
  const auto vt = std::count_if(contacts.begin(), contacts.end(),
                                [](const Contact& c) { return c.kind == ContactKind::vertex_triangle; });
  double earliest = 1.0;
  for (const Contact& contact : contacts) earliest = std::min(earliest, static_cast<double>(contact.time_of_impact));
  EXPECT_GT(vt, 0);
  EXPECT_EQ(s.vt_contacts, static_cast<std::uint64_t>(vt));
  EXPECT_EQ(s.ee_contacts, contacts.size() - static_cast<std::uint64_t>(vt));
  EXPECT_EQ(s.earliest_toi, earliest);
  EXPECT_EQ(s.backend, backend_under_test());
  EXPECT_EQ(s.bodies, scene.size());
  EXPECT_EQ(s.triangles, scene[0].triangles.size() + scene[1].triangles.size());
  EXPECT_EQ(s.vertices, scene[0].x_t1.size() + scene[1].x_t1.size());
  EXPECT_EQ(s.edges, edges_of(scene[0].triangles).size() + edges_of(scene[1].triangles).size());
  EXPECT_EQ(s.active_triangles, s.triangles);
  EXPECT_EQ(s.left_out_triangles, 0U);
}

TEST_P(StatisticsOf, each_stage_hands_on_less_than_it_got) {
  const Statistics s = statistics_of(uneven_scene(), test_options(GetParam()));
  EXPECT_GE(s.vt_candidates, s.vt_contacts);
  EXPECT_GE(s.ee_candidates, s.ee_contacts);
  EXPECT_GE(s.tests, s.triangle_pairs);
  EXPECT_GE(s.entries, s.active_triangles - s.big_triangles);
  EXPECT_GE(s.entries, s.cells);
  EXPECT_GT(s.cells, 0U);
  EXPECT_GT(s.split_triangles, 0U);
  EXPECT_GE(s.children, 4 * s.split_triangles);
  EXPECT_LE(s.flagged_pairs, s.tests);
  EXPECT_GT(s.peak_bytes, 0U);
  EXPECT_GT(s.ms.total, 0.0);
}

// On the CPU the mean radius is that of patches, where there are some.
TEST_P(StatisticsOf, cell_size_is_in_proportion_to_cell_size_factor) {
  PipelineOptions options = test_options(GetParam());
  const Scene scene = uneven_scene();
  const Statistics by_default = statistics_of(scene, options);
  EXPECT_GE(by_default.cell_size, 1.7999 * by_default.mean_radius);
  EXPECT_LE(by_default.cell_size, 3.6 * by_default.mean_radius);
  double radii[2];
  for (const int i : {0, 1}) {
    const double factor = i == 0 ? 1.25 : 1.8;
    options.cell_size_factor = static_cast<float>(factor);
    const Statistics chosen = statistics_of(scene, options);
    EXPECT_EQ(chosen.mean_radius, by_default.mean_radius);
    radii[i] = chosen.cell_size / factor;
  }
  EXPECT_NEAR(radii[0], radii[1], 1e-4 * radii[0]);
  EXPECT_GT(radii[0], 0.8 * by_default.mean_radius);
  EXPECT_LT(radii[0], 4.0 * by_default.mean_radius);
}

TEST_P(StatisticsOf, uniform_grid_tests_more) {
  const Statistics exact = statistics_of(uneven_scene(), test_options(GetParam()));
  const Statistics uniform = statistics_of(uneven_scene(), test_options(GetParam(), BroadPhase::uniform));
  EXPECT_GT(uniform.tests, 2 * exact.tests);
  EXPECT_EQ(uniform.split_triangles, 0U);
  EXPECT_EQ(uniform.children, 0U);
  EXPECT_EQ(uniform.vt_contacts, exact.vt_contacts);
  EXPECT_EQ(uniform.ee_contacts, exact.ee_contacts);
}

Mesh strip(int axis, std::uint32_t triangle_count) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < triangle_count + 2; ++i) {
    const double along = 0.25 * i;
    const double across = i % 2 == 0 ? 0.0 : 0.5;
    const double coordinates[3] = {along, across, 0.0};
    mesh.positions.push_back({coordinates[axis], coordinates[(axis + 2) % 3], coordinates[(axis + 1) % 3]});
  }
  for (std::uint32_t i = 0; i < triangle_count; ++i) mesh.triangles.push_back({{i, i + 1, i + 2}});
  return mesh;
}

TEST_P(StatisticsOf, a_long_strip_costs_no_more_tests_a_triangle) {
  for (int axis = 0; axis < 3; ++axis) {
    const Statistics s = statistics_of({still(strip(axis, 40000), everything(0.01F))}, test_options(GetParam()));
    ASSERT_GT(s.cells, 0U);
    EXPECT_LT(s.tests, 30 * s.triangles) << "along axis " << axis;
  }
}

TEST_P(StatisticsOf, subdivision_off_splits_nothing) {
  PipelineOptions options = test_options(GetParam());
  options.subdivision = false;
  const Statistics s = statistics_of(uneven_scene(), options);
  EXPECT_EQ(s.split_triangles, 0U);
  EXPECT_EQ(s.children, 0U);
}

// The mean radius, with 4 rounds of clipping: one huge triangle must not make all cells large.
TEST_P(StatisticsOf, one_huge_triangle_leaves_the_cells_small) {
  const Mesh sphere = icosphere(4, 1.0);
  const Statistics plain = statistics_of({still(sphere, everything(0.001F))}, test_options(GetParam()));
  Mesh with_huge = sphere;
  with_huge.positions.push_back({1000.0, 1000.0, 1000.0});
  with_huge.triangles.push_back({{0, 1, static_cast<std::uint32_t>(with_huge.positions.size() - 1)}});
  const Statistics huge = statistics_of({still(with_huge, everything(0.001F))}, test_options(GetParam()));
  EXPECT_LT(huge.mean_radius, 1.01 * plain.mean_radius);
  EXPECT_LT(huge.tests, 2 * plain.tests + 4 * plain.triangles);
}

TEST_P(StatisticsOf, kinds_that_nobody_wants_cost_nothing) {
  Scene scene = uneven_scene();
  for (SceneBody& body : scene) body.settings.features = {true, false};
  const Statistics vt = statistics_of(scene, test_options(GetParam()));
  EXPECT_EQ(vt.ee_candidates, 0U);
  EXPECT_GT(vt.vt_candidates, 0U);
  for (SceneBody& body : scene) body.settings.features = {false, true};
  const Statistics ee = statistics_of(scene, test_options(GetParam()));
  EXPECT_EQ(ee.vt_candidates, 0U);
  EXPECT_GT(ee.ee_candidates, 0U);
}

TEST_P(StatisticsOf, bodies_far_apart_are_not_active) {
  Scene scene = uneven_scene(300);
  Mesh away = icosphere(2, 1.0);
  BodySettings settings = everything(0.01F);
  settings.self_collision = false;
  scene.push_back(still(moved(away, {100.0, 0.0, 0.0}), settings));
  const Statistics s = statistics_of(scene, test_options(GetParam()));
  EXPECT_EQ(s.triangles, s.active_triangles + away.triangles.size());
}

TEST_P(StatisticsOf, workspace_stops_growing) {
  LoadedScene loaded = load(uneven_scene(), test_options(GetParam()));
  loaded.pipeline.detect();
  const std::uint64_t bytes = loaded.pipeline.query.statistics().peak_bytes;
  for (int i = 0; i < 5; ++i) loaded.pipeline.detect();
  EXPECT_EQ(loaded.pipeline.query.statistics().peak_bytes, bytes);
  EXPECT_EQ(loaded.pipeline.query.statistics().reruns, 0U);
}

/// Returns the report's only line about a stage.
StageReport line_about(DetectionStage stage, const std::vector<StageReport>& report) {
  const auto is_about = [&](const StageReport& line) { return line.stage == stage; };
  EXPECT_EQ(std::count_if(report.begin(), report.end(), is_about), 1) << name_of(stage);
  const auto found = std::find_if(report.begin(), report.end(), is_about);
  return found == report.end() ? StageReport{} : *found;
}

TEST_P(StatisticsOf, explain_gives_a_reason_for_every_stage) {
  const std::vector<StageReport> report = outcome_of(uneven_scene(200), test_options(GetParam())).report;
  for (std::size_t i = 0; i < report.size(); ++i) {
    EXPECT_FALSE(report[i].reason.empty()) << name_of(report[i].stage);
    EXPECT_TRUE(i == 0 || report[i - 1].stage < report[i].stage) << "not in the order of time";
  }
  const bool is_continuous = GetParam() == Detection::ccd;
  const char* const backend = backend_under_test() == Backend::cuda ? "cuda: " : "cpu: ";
  EXPECT_EQ(line_about(DetectionStage::backend, report).reason.rfind(backend, 0), 0U);
  EXPECT_EQ(line_about(DetectionStage::broad_phase, report).reason.rfind("exact: ", 0), 0U);
  EXPECT_TRUE(line_about(DetectionStage::vertex_triangle_tests, report).ran);
  for (const DetectionStage stage : {DetectionStage::swept_volumes, DetectionStage::time_of_impact}) {
    EXPECT_EQ(line_about(stage, report).ran, is_continuous) << name_of(stage);
  }
  EXPECT_STREQ(name_of(DetectionStage::vertex_triangle_tests), "vertex triangle tests");
  EXPECT_STREQ(name_of(DetectionStage{99}), "unknown");
}

TEST_P(StatisticsOf, explain_says_which_kinds_nobody_wants) {
  for (const Features features : {Features{true, true}, Features{true, false}, Features{false, true}}) {
    Scene scene = uneven_scene(200);
    for (SceneBody& body : scene) body.settings.features = features;
    const std::vector<StageReport> report = outcome_of(scene, test_options(GetParam())).report;
    EXPECT_EQ(line_about(DetectionStage::vertex_triangle_tests, report).ran, features.vertex_triangle);
    EXPECT_EQ(line_about(DetectionStage::edge_edge_tests, report).ran, features.edge_edge);
  }
}

TEST_P(StatisticsOf, explain_says_whether_triangles_had_to_be_split) {
  const Outcome even = outcome_of({still(icosphere(3, 1.0), everything(0.001F))}, test_options(GetParam()));
  EXPECT_EQ(even.statistics.split_triangles, 0U);
  EXPECT_FALSE(line_about(DetectionStage::virtual_subdivision, even.report).ran);
  const Outcome uneven = outcome_of(uneven_scene(), test_options(GetParam()));
  EXPECT_GT(uneven.statistics.split_triangles, 0U);
  const StageReport line = line_about(DetectionStage::virtual_subdivision, uneven.report);
  EXPECT_TRUE(line.ran);
  EXPECT_THAT(line.reason, testing::HasSubstr(std::to_string(uneven.statistics.split_triangles)));
}

INSTANTIATE_TEST_SUITE_P(Kinds, StatisticsOf, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

}  // namespace
}  // namespace softcd::test
