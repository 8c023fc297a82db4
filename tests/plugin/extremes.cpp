#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"

// Scenes at the limits of what a simulation may pass, each judged by exact arithmetic. docs/measured/accuracy.md lists
// them.
namespace softcd::test {
namespace {

/// Memory must grow with the number of results only, whatever makes a scene extreme.
void expect_memory_in_proportion(const Statistics& s) {
  const std::uint64_t lists =
      s.entries + s.children + s.triangle_pairs + s.flagged_pairs + s.vt_candidates + s.ee_candidates;
  const std::uint64_t bound = (4U << 20) + 3072 * s.triangles + 64 * lists + 256 * (s.vt_contacts + s.ee_contacts);
  EXPECT_LE(s.peak_bytes, bound) << s.entries << " entries, " << s.triangle_pairs << " pairs";
}

struct Extreme {
  const char* name;
  Scene (*make)();
};

SoupOptions soup_of(std::uint32_t triangle_count, std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = triangle_count;
  options.half_extent = 2.0;
  options.joined_share = 0.4;
  options.seed = seed;
  return options;
}

/// Returns two bodies made with the same options and different seeds, moved by up to `motion`.
Scene two_of(SoupOptions options, double motion) {
  Scene scene;
  for (int i = 0; i < 2; ++i) {
    ++options.seed;
    const Mesh mesh = triangle_soup(options);
    Positions3 end = jittered(mesh.positions, motion, options.seed);
    snap_to_grid(end, options.grid_bits);
    scene.push_back(moving(mesh, end, everything()));
  }
  return scene;
}

Scene sizes_1_to_10000() {
  SoupOptions options = soup_of(400, 10);
  options.largest = 4.0;
  options.size_ratio = 1e4;
  return two_of(options, 0.05);
}

// 4 long and 2^-18 wide.
Scene needles_1_to_1000000() {
  constexpr int kBits = 18;
  Random random(3);
  Scene scene;
  for (int b = 0; b < 2; ++b) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < 60; ++i) {
      const Vec3d middle = random.in_box(1.0);
      const Vec3d along = 2.0 * random.direction();
      mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
      mesh.positions.push_back(middle - along);
      mesh.positions.push_back(middle + along);
      mesh.positions.push_back(middle + along);
    }
    snap_to_grid(mesh.positions, kBits);
    for (std::size_t i = 2; i < mesh.positions.size(); i += 3) mesh.positions[i].x += std::ldexp(1.0, -kBits);
    Positions3 end = jittered(mesh.positions, 0.3, static_cast<std::uint64_t>(b));
    snap_to_grid(end, kBits);
    scene.push_back(moving(mesh, end, everything()));
  }
  return scene;
}

Scene half_degenerate() {
  SoupOptions options = soup_of(400, 20);
  options.degenerate_share = 0.5;
  return two_of(options, 0.1);
}

// One sheet slides in the plane of the other.
Scene coplanar_sliding() {
  const Mesh sheet = grid_cloth(9, 9, 0.25);
  const Mesh other = moved(grid_cloth(7, 7, 0.375), {0.0625, 0.125, 0.0});
  BodySettings settings = everything();
  settings.self_collision = false;
  return {still(sheet, settings), moving(other, translated(other.positions, {0.5, 0.1875, 0.0}), settings)};
}

Scene all_in_one_cell() {
  SoupOptions options = soup_of(120, 30);
  options.half_extent = 0.0625;
  return two_of(options, 0.05);
}

Scene motion_of_1000_cells() {
  SoupOptions options = soup_of(120, 40);
  options.grid_bits = 11;
  options.half_extent = 100.0;
  Scene scene = two_of(options, 700.0);
  // A quarter of the vertices moves far; the rest is slow, so that cells stay small.
  for (SceneBody& body : scene) {
    for (std::size_t v = 0; v < body.x_t0.size(); ++v) {
      if (v % 12 >= 3) body.x_t1[v] = body.x_t0[v] + Vec3d{0.25, 0, 0};
    }
  }
  return scene;
}

Scene one_vertex_at_1e30() {
  const auto distant = static_cast<double>(1e30F);
  Scene scene = two_of(soup_of(200, 50), 0.1);
  scene[0].x_t0[7] = scene[0].x_t1[7] = {distant, -distant, 0.5 * distant};
  scene[1].x_t1[11] = {-distant, 0.0, 0.25 * distant};
  return scene;
}

Scene one_not_a_number() {
  Scene scene = two_of(soup_of(300, 60), 0.1);
  scene[0].x_t1[5].y = std::numeric_limits<double>::quiet_NaN();
  return scene;
}

Scene coincident_triangles() {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 60; ++i) {
    mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  }
  return {moving(mesh, translated(mesh.positions, {0.5, 0.25, 1.0}), everything()), still(mesh, everything())};
}

Scene one_triangle_each() {
  const Mesh triangle{{{{0, 1, 2}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Mesh other = moved(triangle, {0.25, 0.25, 0.5});
  return {still(triangle, everything()), moving(other, translated(other.positions, {0, 0, -1}), everything())};
}

Scene nothing_and_one_triangle() {
  return {still(Mesh{}, everything()), one_triangle_each()[0]};
}

std::ostream& operator<<(std::ostream& out, const Extreme& extreme) {
  return out << extreme.name;
}

PipelineOptions options_for(Detection detection, Accuracy accuracy) {
  PipelineOptions options = test_options(detection);
  options.accuracy = accuracy;
  return options;
}

class Extremes : public testing::TestWithParam<Extreme> {};

INSTANTIATE_TEST_SUITE_P(
    Scenes, Extremes,
    testing::Values(Extreme{"sizes_1_to_10000", sizes_1_to_10000},
                    Extreme{"needles_1_to_1000000", needles_1_to_1000000}, Extreme{"half_degenerate", half_degenerate},
                    Extreme{"coplanar_sliding", coplanar_sliding}, Extreme{"all_in_one_cell", all_in_one_cell},
                    Extreme{"motion_of_1000_cells", motion_of_1000_cells},
                    Extreme{"one_vertex_at_1e30", one_vertex_at_1e30}, Extreme{"one_not_a_number", one_not_a_number},
                    Extreme{"coincident_triangles", coincident_triangles},
                    Extreme{"one_triangle_each", one_triangle_each},
                    Extreme{"nothing_and_one_triangle", nothing_and_one_triangle}),
    [](const auto& test) { return test.param.name; });

TEST_P(Extremes, touch_exactly_where_they_touch) {
  const Scene scene = GetParam().make();
  expect_continuous_contacts(scene, options_for(Detection::ccd, Accuracy::precise));
  const Outcome precise = outcome_of(scene, options_for(Detection::ccd, Accuracy::precise));
  const Outcome conservative = outcome_of(scene, options_for(Detection::ccd, Accuracy::conservative));
  EXPECT_EQ(features_of(precise.contacts), features_of(conservative.contacts));
  EXPECT_EQ(conservative.statistics.unsettled_contacts, 0U);
  expect_memory_in_proportion(conservative.statistics);
}

TEST_P(Extremes, are_near_exactly_where_they_are_near) {
  for (const float margin : {0.0F, 0.015625F}) {
    Scene scene = GetParam().make();
    for (SceneBody& body : scene) body.settings.margin = margin;
    DiscreteRules rules;
    rules.absolute_band = 1e-15 * half_extent_of(scene);
    expect_discrete_contacts(scene, options_for(Detection::dcd, Accuracy::precise), rules);
    expect_discrete_contacts(scene, options_for(Detection::dcd, Accuracy::conservative), rules);
    expect_memory_in_proportion(outcome_of(scene, options_for(Detection::dcd, Accuracy::precise)).statistics);
  }
}

TEST_P(Extremes, come_near_without_a_miss_in_conservative) {
  Scene scene = GetParam().make();
  for (SceneBody& body : scene) body.settings.margin = 0.015625F;
  const Outcome outcome = outcome_of(scene, options_for(Detection::ccd, Accuracy::conservative));
  expect_nothing_missed_on_the_way(scene, outcome.contacts);
  expect_memory_in_proportion(outcome.statistics);
  std::cout << outcome.contacts.size() << " contacts, " << outcome.statistics.unsettled_contacts << " unsettled, "
            << outcome.statistics.tests << " tests, " << outcome.statistics.peak_bytes / 1000 << " kB\n";
}

/// A fine sheet without a margin under a coarse one whose margin is `margin` edges of the fine one.
Scene margins_that_differ(std::uint32_t columns, float margin) {
  const double edge = 1.0 / columns;
  const Mesh fine = grid_cloth(columns, columns, edge);
  const Mesh coarse = moved(grid_cloth(columns / 3, columns / 3, 3 * edge), {0.0, 0.0, 2 * edge});
  BodySettings settings;
  settings.features = {true, true};
  Scene scene = {still(fine, settings)};
  settings.margin = margin * static_cast<float>(edge);
  scene.push_back(still(coarse, settings));
  return scene;
}

TEST(ExtremeMargins, take_entries_in_proportion_to_triangles) {
  const Scene scene = margins_that_differ(60, 20.0F);
  const Outcome exact = outcome_of(scene, test_options(Detection::dcd));
  const Outcome uniform = outcome_of(scene, test_options(Detection::dcd, BroadPhase::uniform));
  ASSERT_GT(exact.contacts.size(), 100'000U);
  EXPECT_TRUE(identical(exact.contacts, uniform.contacts));
  EXPECT_LE(exact.statistics.entries, 12 * exact.statistics.triangles);
}

TEST(ExtremeMargins, do_not_fill_the_cells_of_a_given_cell_size_factor) {
  const Scene scene = margins_that_differ(24, 4.0F);
  const std::vector<Contact> expected = detect_once(scene, test_options(Detection::dcd));
  ASSERT_GT(expected.size(), 500U);
  PipelineOptions options = test_options(Detection::dcd);
  options.cell_size_factor = 0.1F;
  const Outcome outcome = outcome_of(scene, options);
  EXPECT_TRUE(identical(expected, outcome.contacts));
  EXPECT_LE(outcome.statistics.entries, 500 * outcome.statistics.triangles);
}

/// Coarse enough that moving the origin and scaling by powers of two keep positions exact.
Scene coarse(float margin) {
  SoupOptions options = soup_of(250, 70);
  options.size_ratio = 20.0;
  options.grid_bits = 12;
  Scene scene = two_of(options, 0.2);
  for (SceneBody& body : scene) body.settings.margin = margin;
  return scene;
}

class ExtremePlaces : public testing::TestWithParam<Accuracy> {};

INSTANTIATE_TEST_SUITE_P(Accuracies, ExtremePlaces, testing::Values(Accuracy::precise, Accuracy::conservative),
                         [](const auto& test) { return test.param == Accuracy::precise ? "precise" : "conservative"; });

Scene shifted(Scene scene, Vec3d offset) {
  for (SceneBody& body : scene) {
    body.x_t0 = translated(body.x_t0, offset);
    body.x_t1 = translated(body.x_t1, offset);
  }
  return scene;
}

TEST_P(ExtremePlaces, offsets_from_1_to_1e7_change_no_verdict) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const PipelineOptions options = options_for(detection, GetParam());
    const Scene scene = coarse(0.015625F);
    const std::vector<Contact> expected = detect_once(scene, options);
    ASSERT_GT(expected.size(), 100U);
    for (const double offset : {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7}) {
      const std::vector<Contact> found = detect_once(shifted(scene, {offset, -offset, 0.5 * offset}), options);
      EXPECT_EQ(features_of(expected), features_of(found)) << offset;
    }
  }
}

TEST_P(ExtremePlaces, scales_from_1e_minus_6_to_1e6_change_no_verdict) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const PipelineOptions options = options_for(detection, GetParam());
    const std::vector<FeaturePair> expected = features_of(detect_once(coarse(0.015625F), options));
    for (const int exponent : {-20, -10, 10, 20}) {
      Scene scene = coarse(std::ldexp(0.015625F, exponent));
      for (SceneBody& body : scene) {
        body.x_t0 = contracted(body.x_t0, std::ldexp(1.0, exponent));
        body.x_t1 = contracted(body.x_t1, std::ldexp(1.0, exponent));
      }
      EXPECT_EQ(expected, features_of(detect_once(scene, options))) << "2^" << exponent;
    }
  }
}

TEST_P(ExtremePlaces, a_margin_of_the_scenes_size_pairs_everything_at_the_start) {
  Scene scene = two_of(soup_of(40, 80), 0.2);
  for (SceneBody& body : scene) body.settings.margin = 100.0F;
  const std::vector<Contact> contacts = detect_once(scene, options_for(Detection::ccd, GetParam()));
  EXPECT_EQ(features_of(contacts), discrete_verdicts(scene).certain);
  for (const Contact& contact : contacts) EXPECT_EQ(contact.time_of_impact, 0.0F);
}

}  // namespace
}  // namespace softcd::test
