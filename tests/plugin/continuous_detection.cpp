#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <ostream>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

enum class Motion { slow, jitter, fast_few, inward };

struct MotionCase {
  std::uint32_t triangle_count;
  double size_ratio;
  Motion motion;
  std::uint64_t seed;

  friend std::ostream& operator<<(std::ostream& out, const MotionCase& c) {
    return out << c.triangle_count << " triangles, sizes 1:" << c.size_ratio << ", motion "
               << static_cast<int>(c.motion) << ", seed " << c.seed;
  }
};

Positions3 end_of(const Mesh& mesh, Motion motion, std::uint64_t seed) {
  Positions3 x;
  switch (motion) {
    case Motion::slow:
      x = jittered(mesh.positions, 0.01, seed);
      break;
    case Motion::jitter:
      x = jittered(mesh.positions, 0.3, seed);
      break;
    case Motion::fast_few:
      x = scattered(mesh, 4.0, seed);
      break;
    case Motion::inward:
      x = contracted(mesh.positions, 0.75);
      break;
  }
  snap_to_grid(x, 17);
  return x;
}

Scene soup_scene(const MotionCase& c, std::uint32_t body_count) {
  Scene scene;
  for (std::uint32_t i = 0; i < body_count; ++i) {
    SoupOptions options;
    options.triangle_count = c.triangle_count / body_count;
    options.size_ratio = c.size_ratio;
    options.half_extent = 2.5;
    options.largest = c.size_ratio > 10.0 ? 2.0 : 0.4;
    options.needle_share = 0.05;
    options.degenerate_share = 0.05;
    options.joined_share = 0.3;
    options.seed = c.seed + 1000 * i;
    const Mesh mesh = triangle_soup(options);
    scene.push_back(moving(mesh, end_of(mesh, c.motion, c.seed + i), everything()));
  }
  return scene;
}

class ContinuousSoup : public testing::TestWithParam<MotionCase> {};

TEST_P(ContinuousSoup, one_body_with_itself) {
  EXPECT_GT(expect_continuous_contacts(soup_scene(GetParam(), 1), test_options(Detection::ccd)), 0U);
}

TEST_P(ContinuousSoup, three_bodies) {
  EXPECT_GT(expect_continuous_contacts(soup_scene(GetParam(), 3), test_options(Detection::ccd)), 0U);
}

TEST_P(ContinuousSoup, conservative) {
  PipelineOptions options = test_options(Detection::ccd);
  options.accuracy = Accuracy::conservative;
  EXPECT_GT(expect_continuous_contacts(soup_scene(GetParam(), 2), options), 0U);
}

// Discrete detections on the path find nothing that `conservative` misses or reports later. `precise` does miss some.
TEST_P(ContinuousSoup, conservative_finds_whatever_comes_within_the_margin) {
  Scene scene = soup_scene(GetParam(), 2);
  for (SceneBody& body : scene) body.settings.margin = 0.02F;
  PipelineOptions options = test_options(Detection::ccd);
  const std::vector<FeaturePair> precise = features_of(detect_once(scene, options));
  options.accuracy = Accuracy::conservative;
  const std::vector<Contact> contacts = detect_once(scene, options);
  expect_flawless(scene, contacts, Detection::ccd, point_tolerance(scene));
  const std::size_t missed_by_precise = expect_nothing_missed_on_the_way(scene, contacts, precise);
  std::cout << contacts.size() << " contacts, of which `precise` finds " << precise.size()
            << "; discrete ones missed by it " << missed_by_precise << "\n";
  EXPECT_GE(contacts.size(), precise.size());
}

TEST_P(ContinuousSoup, other_ways_give_the_same_bytes) {
  const Scene scene = soup_scene(GetParam(), 2);
  PipelineOptions options = test_options(Detection::ccd);
  const std::vector<Contact> expected = detect_once(scene, options);
  options.subdivision = false;
  EXPECT_TRUE(identical(expected, detect_once(scene, options))) << "without subdivision";
  options = test_options(Detection::ccd, BroadPhase::uniform);
  EXPECT_TRUE(identical(expected, detect_once(scene, options))) << "uniform grid";
  for (const float factor : {0.8F, 1.3F, 2.4F}) {
    options = test_options(Detection::ccd);
    options.cell_size_factor = factor;
    EXPECT_TRUE(identical(expected, detect_once(scene, options))) << "cell_size_factor " << factor;
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, ContinuousSoup,
                         testing::Values(MotionCase{400, 1.0, Motion::jitter, 1},
                                         MotionCase{800, 30.0, Motion::slow, 2},
                                         MotionCase{600, 100.0, Motion::fast_few, 3},
                                         MotionCase{800, 1000.0, Motion::inward, 4}));

TEST(ContinuousDetection, cloth_falls_onto_a_sphere) {
  Mesh cloth = moved(grid_cloth(25, 25, 0.125), {0.03125, 0.015625, 1.25});
  Mesh sphere = icosphere(3, 1.0);
  snap_to_grid(sphere.positions, 17);
  Positions3 end = jittered(translated(cloth.positions, {0.0, 0.0, -0.75}), 0.05, 2);
  snap_to_grid(end, 17);
  BodySettings of_sphere = everything();
  of_sphere.kinematic = true;
  of_sphere.self_collision = false;
  const Scene scene{moving(cloth, end, everything()), still(sphere, of_sphere)};
  EXPECT_GT(expect_continuous_contacts(scene, test_options(Detection::ccd)), 100U);
}

TEST(ContinuousDetection, nothing_moves_apart_triangles) {
  const Scene scene{still(moved(icosphere(1, 1.0), {-2.0, 0, 0}), everything()),
                    still(moved(icosphere(1, 1.0), {2.0, 0, 0}), everything())};
  EXPECT_EQ(expect_continuous_contacts(scene, test_options(Detection::ccd)), 0U);
}

// A vertex falls through a resting triangle from z = 1 to z = -3.
TEST(ContinuousDetection, vertex_through_triangle) {
  const Mesh floor{{{{0, 1, 2}}}, {{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}};
  const Mesh point{{{{0, 0, 0}}}, {{0.125, 0.25, 1}}};
  const Scene scene{still(floor, everything()), moving(point, {{0.125, 0.25, -3}}, everything())};
  const std::vector<Contact> contacts = detect_once(scene, test_options(Detection::ccd));
  ASSERT_EQ(contacts.size(), 1U);
  const Contact& contact = contacts[0];
  EXPECT_EQ(features_of(contact), (FeaturePair{ContactKind::vertex_triangle, 1, 0, 0, 0}));
  EXPECT_FLOAT_EQ(contact.time_of_impact, 0.25F);
  EXPECT_NEAR(contact.distance, 0.0F, 1e-6F);
  EXPECT_FLOAT_EQ(contact.normal.z, 1.0F);
  EXPECT_FLOAT_EQ(contact.weights[1], 0.208333333F);
  EXPECT_FLOAT_EQ(contact.weights[2], 0.375F);
  EXPECT_FLOAT_EQ(contact.weights[3], 0.416666667F);
}

// An edge along x rises through a resting edge along y.
TEST(ContinuousDetection, edge_through_edge) {
  const Mesh first{{{{0, 1, 1}}}, {{0, -1, 0}, {0, 1, 0}}};
  const Mesh second{{{{0, 1, 1}}}, {{-1, 0.5, -1}, {3, 0.5, -1}}};
  BodySettings edges_only = everything();
  edges_only.features = {false, true};
  const Scene scene{still(first, edges_only), moving(second, {{-1, 0.5, 1}, {3, 0.5, 1}}, edges_only)};
  const std::vector<Contact> contacts = detect_once(scene, test_options(Detection::ccd));
  ASSERT_EQ(contacts.size(), 1U);
  const Contact& contact = contacts[0];
  EXPECT_EQ(features_of(contact), (FeaturePair{ContactKind::edge_edge, 0, 0, 1, 0}));
  EXPECT_FLOAT_EQ(contact.time_of_impact, 0.5F);
  EXPECT_FLOAT_EQ(contact.normal.z, 1.0F) << "side a, the resting edge, was above";
  EXPECT_FLOAT_EQ(contact.weights[0], 0.25F);
  EXPECT_FLOAT_EQ(contact.weights[1], 0.75F);
  EXPECT_FLOAT_EQ(contact.weights[2], 0.75F);
  EXPECT_FLOAT_EQ(contact.weights[3], 0.25F);
}

// With a margin, features that touch, or are within the margin at either end, are reported. Reported features are
// within the margin at their time.
TEST(ContinuousDetection, margins) {
  Scene scene = soup_scene({500, 20.0, Motion::jitter, 11}, 2);
  const std::vector<FeaturePair> touching = continuous_verdicts(scene).certain;
  scene[0].settings.margin = 0.01F;
  scene[1].settings.margin = 0.03F;
  Scene start = scene;
  for (SceneBody& body : start) body.x_t1 = body.x_t0;
  const std::vector<Contact> contacts = detect_once(scene, test_options(Detection::ccd));
  const std::vector<FeaturePair> reported = features_of(contacts);
  for (const std::vector<FeaturePair>& required :
       {touching, discrete_verdicts(start).certain, discrete_verdicts(scene).certain}) {
    const Difference difference = compare({required, {}}, reported);
    EXPECT_TRUE(difference.missed.empty()) << describe(difference);
    EXPECT_FALSE(required.empty());
  }
  const SceneGeometry geometry(scene);
  for (const Contact& contact : contacts) {
    const double limit = static_cast<double>(scene[contact.body_a.value].settings.margin) +
                         static_cast<double>(scene[contact.body_b.value].settings.margin);
    EXPECT_LE(geometry.distance_near(features_of(contact), contact.time_of_impact), limit * (1.0 + 1e-5))
        << features_of(contact);
  }
}

}  // namespace
}  // namespace softcd::test
