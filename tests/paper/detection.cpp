#include <gtest/gtest.h>

#include <iostream>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "paper_outcome.hpp"

namespace softcd::paper {
namespace {

using test::everything;
using test::Mesh;
using test::Scene;
using test::SoupOptions;
using test::test_options;

/// Two soups of large and small triangles.
Scene soups(std::uint32_t triangle_count, double size_ratio, double motion) {
  Scene scene;
  for (std::uint64_t i = 0; i < 2; ++i) {
    SoupOptions options;
    options.triangle_count = triangle_count / 2;
    options.size_ratio = size_ratio;
    options.half_extent = 2.5;
    options.largest = size_ratio > 10.0 ? 2.0 : 0.4;
    options.needle_share = 0.05;
    options.degenerate_share = 0.05;
    options.joined_share = 0.3;
    options.seed = 7 + 1000 * i;
    const Mesh mesh = triangle_soup(options);
    scene.push_back(moving(mesh, test::jittered(mesh.positions, motion, i), everything(0.01F)));
  }
  return scene;
}

class PrintedScheme : public testing::TestWithParam<Detection> {};
INSTANTIATE_TEST_SUITE_P(Detections, PrintedScheme, testing::Values(Detection::dcd, Detection::ccd));

TEST_P(PrintedScheme, reports_nothing_that_is_not_there_and_nothing_twice) {
  for (const double size_ratio : {1.0, 30.0, 1000.0}) {
    const Scene scene = soups(1000, size_ratio, 0.1);
    const std::vector<Contact> exact = detect_once(scene, test_options(GetParam()));
    const std::vector<Contact> contacts = outcome_by_paper(scene, test_options(GetParam())).contacts;
    const test::Difference difference = test::compare({test::features_of(exact), {}}, test::features_of(contacts));
    EXPECT_TRUE(difference.extra.empty() && difference.repeated.empty()) << test::describe(difference);
    EXPECT_GT(contacts.size(), exact.size() / 2);
    test::expect_sorted(contacts);
    std::cout << difference.missed.size() << " of " << exact.size() << " contacts missed\n";
  }
}

TEST_P(PrintedScheme, splits_in_space_and_in_time) {
  const Scene scene = soups(1000, 200.0, 0.1);
  PipelineOptions options = test_options(GetParam());
  const Statistics split = outcome_by_paper(scene, options).statistics;
  EXPECT_NEAR(split.cell_size, 3.0 * 1.2 * split.mean_radius, 1e-4 * split.cell_size);
  EXPECT_GT(split.split_triangles, 0U);
  EXPECT_GT(split.children, 2 * split.split_triangles);
  EXPECT_GE(split.flagged_pairs, split.triangle_pairs) << "every pair is made unique";
  options.subdivision = false;
  const Statistics whole = outcome_by_paper(scene, options).statistics;
  EXPECT_EQ(whole.split_triangles, 0U);
  EXPECT_GT(whole.tests, split.tests);
}

TEST(PrintedScheme, does_not_multiply_its_work_by_large_margins) {
  for (const std::uint32_t columns : {8U, 24U}) {
    const double edge = 1.0 / columns;
    const Mesh fine = test::grid_cloth(columns, columns, edge);
    const Mesh coarse = moved(test::grid_cloth(columns / 3, columns / 3, 3 * edge), {0.0, 0.0, 2 * edge});
    BodySettings settings;
    settings.features = {true, true};
    settings.self_collision = false;
    Scene scene = {still(fine, settings)};
    settings.margin = 40.0F * static_cast<float>(edge);
    scene.push_back(still(coarse, settings));
    const Statistics s = outcome_by_paper(scene, test_options(Detection::dcd)).statistics;
    EXPECT_LE(s.entries, 256 * s.triangles + 65536);
    EXPECT_EQ(s.children, 0U);
  }
}

TEST_P(PrintedScheme, returns_the_same_bytes_on_the_cpu_and_on_cuda) {
  const Scene scene = soups(1500, 500.0, 0.3);
  for (const Accuracy accuracy : {Accuracy::fast, Accuracy::precise}) {
    PipelineOptions options = test_options(GetParam());
    options.accuracy = accuracy;
    const test::Outcome tested = outcome_by_paper(scene, options);
    options.backend = Backend::cpu;
    const test::Outcome expected = outcome_by_paper(scene, options);
    EXPECT_TRUE(test::identical(expected.contacts, tested.contacts));
    EXPECT_EQ(expected.statistics.tests, tested.statistics.tests);
  }
}

}  // namespace
}  // namespace softcd::paper
