#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "expectations.hpp"
#include "fans.hpp"
#include "mesh_generators.hpp"
#include "reference_distance.hpp"

namespace softcd::test {
namespace {

struct Vec3l {
  long double x, y, z;
};

Vec3l between(Vec3d from, Vec3d to) {
  return {static_cast<long double>(to.x) - from.x, static_cast<long double>(to.y) - from.y,
          static_cast<long double>(to.z) - from.z};
}

long double dot(Vec3l a, Vec3l b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Returns how far inside (above 0) or outside (below 0) of ContactRule::slab a vertex is, relative to the margin. The
/// formula is Bullet's, with quotients of the triangle's Gram matrix.
long double depth_in_slab(Vec3d v, Vec3d f0, Vec3d f1, Vec3d f2, long double margin) {
  const Vec3l side0 = between(f2, f0);
  const Vec3l side1 = between(f2, f1);
  const Vec3l offset = between(f2, v);
  const long double a00 = dot(side0, side0);
  const long double a11 = dot(side1, side1);
  const long double a01 = dot(side0, side1);
  const long double determinant = a00 * a11 - a01 * a01;  // four times the squared area
  const long double area = std::sqrt(determinant) / 2;
  const long double distance = distance_vertex_triangle(v, f0, f1, f2);
  if (!(area > 1e-12L * (a00 + a11))) return (margin - distance) / margin;

  const long double w0 = (dot(offset, side0) * a11 - dot(offset, side1) * a01) / determinant;
  const long double w1 = (dot(offset, side1) * a00 - dot(offset, side0) * a01) / determinant;
  const Vec3l normal = {side0.y * side1.z - side0.z * side1.y, side0.z * side1.x - side0.x * side1.z,
                        side0.x * side1.y - side0.y * side1.x};
  const long double height = std::fabs(dot(offset, normal)) / std::sqrt(determinant);
  const long double slack = margin / std::sqrt(area);
  long double depth = std::min((margin - height) / margin, (std::sqrt(5.0L) * margin - distance) / margin);
  for (const long double weight : {w0, w1, 1 - w0 - w1}) {
    depth = std::min({depth, (weight + slack) / slack, (1 + slack - weight) / slack});
  }
  return depth;
}

std::set<std::uint32_t> used_vertices(const SceneBody& body) {
  std::set<std::uint32_t> used;
  for (const Triangle& triangle : body.triangles) used.insert(triangle.v, triangle.v + 3);
  return used;
}

/// Returns certain and undecided vertex-triangle pairs of the rule, over all pairs.
Verdicts slab_verdicts(const Scene& scene, long double band) {
  Verdicts verdicts;
  for (std::uint32_t a = 0; a < scene.size(); ++a) {
    for (std::uint32_t b = 0; b < scene.size(); ++b) {
      const long double margin = static_cast<long double>(scene[a].settings.margin) + scene[b].settings.margin;
      const Positions3& x = scene[b].x_t1;
      for (const std::uint32_t v : used_vertices(scene[a])) {
        for (std::uint32_t t = 0; t < scene[b].triangles.size(); ++t) {
          const auto [f0, f1, f2] = scene[b].triangles[t].v;
          if (a == b && (v == f0 || v == f1 || v == f2)) continue;
          const long double depth = depth_in_slab(scene[a].x_t1[v], x[f0], x[f1], x[f2], margin);
          const FeaturePair pair{ContactKind::vertex_triangle, a, v, b, t};
          if (depth > band) verdicts.certain.push_back(pair);
          if (std::fabs(depth) <= band) verdicts.undecided.push_back(pair);
        }
      }
    }
  }
  std::sort(verdicts.certain.begin(), verdicts.certain.end());
  std::sort(verdicts.undecided.begin(), verdicts.undecided.end());
  return verdicts;
}

PipelineOptions slab_options(BroadPhase broad_phase = BroadPhase::exact) {
  PipelineOptions options = test_options(Detection::dcd, broad_phase);
  options.contact_rule = ContactRule::slab;
  return options;
}

Scene two_soups(std::uint64_t seed, double needle_share) {
  Scene scene;
  for (std::uint64_t i = 0; i < 2; ++i) {
    SoupOptions soup;
    soup.triangle_count = 250;
    soup.size_ratio = 5.0;
    soup.half_extent = 1.0;
    soup.largest = 0.5;
    soup.needle_share = needle_share;
    soup.joined_share = 0.5;
    soup.seed = 10 * seed + i;
    scene.push_back(still(triangle_soup(soup), everything(0.02F + 0.03F * static_cast<float>(i))));
    scene.back().settings.features.edge_edge = false;
  }
  return scene;
}

class SlabRule : public testing::TestWithParam<BroadPhase> {};
INSTANTIATE_TEST_SUITE_P(BroadPhases, SlabRule, testing::Values(BroadPhase::exact, BroadPhase::uniform));

TEST_P(SlabRule, finds_what_the_formula_over_all_pairs_finds) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Scene scene = two_soups(seed, seed % 2 == 0 ? 0.0 : 0.2);
    const std::vector<Contact> contacts = detect_once(scene, slab_options(GetParam()));
    const Difference difference = compare(slab_verdicts(scene, 1e-5L), features_of(contacts));
    EXPECT_TRUE(agrees(difference)) << describe(difference);
    EXPECT_GT(contacts.size(), 1000U);
    EXPECT_NE(features_of(contacts), features_of(detect_once(scene, test_options(Detection::dcd))));
  }
}

TEST_P(SlabRule, reaches_far_around_a_vertex_of_many_triangles) {
  for (const NamedFan& fan : fans(120)) {
    SCOPED_TRACE(fan.name);
    for (const float margin : {0.01F, 0.1F}) {
      Scene scene{still(fan.mesh, everything(margin))};
      scene[0].settings.features.edge_edge = false;
      const std::vector<Contact> contacts = detect_once(scene, slab_options(GetParam()));
      const Difference difference = compare(slab_verdicts(scene, 1e-5L), features_of(contacts));
      EXPECT_TRUE(agrees(difference)) << describe(difference);
    }
  }
}

TEST(SlabContact, lies_in_the_plane_with_the_normal_on_the_vertexs_side) {
  const Scene scene = two_soups(7, 0.0);
  bool leaves_triangle = false;
  for (const Contact& contact : detect_once(scene, slab_options())) {
    const Vec3d v = scene[contact.body_a.value].x_t1[contact.vertices[0]];
    Vec3d foot{0, 0, 0};
    double sum = 0;
    for (int corner = 1; corner < 4; ++corner) {
      const auto weight = static_cast<double>(contact.weights[corner]);
      foot = foot + weight * scene[contact.body_b.value].x_t1[contact.vertices[corner]];
      sum += weight;
      leaves_triangle |= weight < 0;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
    const Vec3d expected = foot + static_cast<double>(contact.distance) * vec3_cast<double>(contact.normal);
    EXPECT_LT(squared_norm(v - expected), 1e-10);
    EXPECT_NEAR(squared_norm(vec3_cast<double>(contact.normal)), 1, 1e-6);
  }
  EXPECT_TRUE(leaves_triangle);
}

TEST(SlabRule, leaves_edges_and_continuous_detection_alone) {
  Scene scene = two_soups(3, 0.1);
  for (SceneBody& body : scene) body.settings.features = {false, true};
  const std::vector<Contact> edges = detect_once(scene, slab_options());
  EXPECT_FALSE(edges.empty());
  EXPECT_TRUE(identical(edges, detect_once(scene, test_options(Detection::dcd))));
  for (SceneBody& body : scene) body.settings.features = {true, true};
  PipelineOptions continuous = slab_options();
  continuous.detection = Detection::ccd;
  const std::vector<Contact> on_the_way = detect_once(scene, continuous);
  EXPECT_FALSE(on_the_way.empty());
  EXPECT_TRUE(identical(on_the_way, detect_once(scene, test_options(Detection::ccd))));
}

// The reach of such a margin is infinite in float32.
TEST(SlabRule, never_has_contacts_with_a_body_that_is_nowhere) {
  Scene scene = two_soups(5, 0.0);
  for (SceneBody& body : scene) {
    body.settings.margin = 2.0e38F;
    body.settings.self_collision = false;
  }
  LoadedScene loaded = load({scene[0]}, slab_options());
  const auto vertex_count = static_cast<std::uint32_t>(scene[1].x_t1.size());
  const BodyId nowhere = loaded.pipeline.scene.add_body({scene[1].triangles, vertex_count, scene[1].settings});
  EXPECT_TRUE(loaded.pipeline.detect().empty());
  loaded.pipeline.scene.set_positions(nowhere, scene[1].x_t0, scene[1].x_t1);
  EXPECT_FALSE(loaded.pipeline.detect().empty());
}

TEST(SlabRule, takes_a_triangle_without_area_for_the_segment_or_point_that_it_is) {
  Scene scene;
  scene.push_back(still({{{{0, 1, 1}}, {{2, 2, 2}}}, {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}}, everything(0.05F)));
  scene.push_back(
      still({{{{0, 0, 0}}, {{1, 1, 1}}, {{2, 2, 2}}}, {{0.5, 0.08, 0}, {3, 0.08, 0}, {1.2, 0, 0}}}, everything(0.05F)));
  const std::vector<Contact> contacts = detect_once(scene, slab_options());
  EXPECT_EQ(features_of(contacts), features_of(detect_once(scene, test_options(Detection::dcd))));
  EXPECT_FALSE(contacts.empty());
}

/// Returns the largest gap along x, y or z between the boxes of ContactRule::ahead, below 0 if they overlap.
double gap_of_boxes_ahead(const SceneBody& a, std::uint32_t vertex, const SceneBody& b, const Triangle& triangle) {
  const double margins = 2 * (static_cast<double>(a.settings.margin) + static_cast<double>(b.settings.margin));
  double gap = -1e9;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](const Positions3& x, std::uint32_t v) { return x[v][axis]; };
    const double motion = 3 * (at(a.x_t1, vertex) - at(a.x_t0, vertex));
    const double lo = at(a.x_t1, vertex) + std::min(0.0, motion);
    const double hi = at(a.x_t1, vertex) + std::max(0.0, motion);
    double face_lo = 1e9;
    double face_hi = -1e9;
    double mean = 0;
    for (const std::uint32_t v : triangle.v) {
      face_lo = std::min(face_lo, at(b.x_t1, v));
      face_hi = std::max(face_hi, at(b.x_t1, v));
      mean += (at(b.x_t1, v) - at(b.x_t0, v)) / 3;
    }
    gap = std::max(
        {gap, lo - (face_hi + std::max(0.0, 3 * mean)) - margins, (face_lo + std::min(0.0, 3 * mean)) - hi - margins});
  }
  return gap;
}

/// Returns verdicts over all pairs by ContactRule::ahead.
Verdicts ahead_verdicts(const Scene& scene, double motion_margin) {
  DiscreteRules rules;
  rules.motion_margin = motion_margin;
  Verdicts verdicts = discrete_verdicts(scene, rules);
  constexpr double kBand = 1e-5;
  const auto gap_of = [&](const FeaturePair& pair) {
    if (pair.kind == ContactKind::edge_edge) return -1.0;
    const SceneBody& b = scene[pair.body_b];
    return gap_of_boxes_ahead(scene[pair.body_a], pair.feature_a, b, b.triangles[pair.feature_b]);
  };
  const auto first_not_certain = std::stable_partition(verdicts.certain.begin(), verdicts.certain.end(),
                                                       [&](const FeaturePair& pair) { return gap_of(pair) < -kBand; });
  for (auto pair = first_not_certain; pair != verdicts.certain.end(); ++pair) {
    if (gap_of(*pair) <= kBand) verdicts.undecided.push_back(*pair);
  }
  verdicts.certain.erase(first_not_certain, verdicts.certain.end());
  std::sort(verdicts.certain.begin(), verdicts.certain.end());
  std::sort(verdicts.undecided.begin(), verdicts.undecided.end());
  return verdicts;
}

/// Returns soups of small triangles that each move as a whole, up to half a triangle apart from that.
Scene soups_in_motion(std::uint64_t seed, const std::vector<Vec3d>& motions) {
  Scene scene;
  for (const Vec3d& motion : motions) {
    SoupOptions soup;
    soup.triangle_count = 150;
    soup.size_ratio = 8.0;
    soup.half_extent = 1.0;
    soup.largest = 0.4;
    soup.joined_share = 0.5;
    soup.seed = ++seed;
    const Mesh mesh = triangle_soup(soup);
    Positions3 x_t0 = jittered(mesh.positions, 0.03, seed);
    for (Vec3d& x : x_t0) x = x - motion;
    snap_to_grid(x_t0, 17);
    scene.push_back({mesh.triangles, x_t0, mesh.positions, everything(0.01F * static_cast<float>(1 + scene.size()))});
  }
  return scene;
}

class AheadRule : public testing::TestWithParam<BroadPhase> {};
INSTANTIATE_TEST_SUITE_P(BroadPhases, AheadRule, testing::Values(BroadPhase::exact, BroadPhase::uniform));

TEST_P(AheadRule, finds_what_lies_ahead_among_what_the_motion_margin_finds) {
  const std::vector<std::vector<Vec3d>> motions = {
      {{0.5, 0, 0}, {0, 0, 0}}, {{0.4, 0.1, 0}, {-0.3, 0, 0.2}}, {{0, -0.3, 0}, {0, -0.3, 0.01}, {0, 0.02, 0}}};
  for (const std::vector<Vec3d>& each : motions) {
    const Scene scene = soups_in_motion(20, each);
    for (const float motion_margin : {0.5F, 2.0F, 4.0F}) {
      PipelineOptions options = test_options(Detection::dcd, GetParam());
      options.motion_margin = motion_margin;
      const std::size_t around = detect_once(scene, options).size();
      options.contact_rule = ContactRule::ahead;
      const std::vector<Contact> contacts = detect_once(scene, options);
      const Difference difference =
          compare(ahead_verdicts(scene, static_cast<double>(motion_margin)), features_of(contacts));
      EXPECT_TRUE(agrees(difference)) << describe(difference);
      EXPECT_LT(contacts.size(), around);
      EXPECT_GT(contacts.size(), 1000U);
    }
  }
}

// All that the margins alone find lies ahead.
TEST(AheadRule, is_the_distance_without_a_motion_margin) {
  const Scene scene = soups_in_motion(40, {{0.5, 0, 0}, {0, -0.2, 0}});
  PipelineOptions options = test_options(Detection::dcd);
  const std::vector<Contact> by_distance = detect_once(scene, options);
  EXPECT_FALSE(by_distance.empty());
  options.contact_rule = ContactRule::ahead;
  EXPECT_TRUE(identical(detect_once(scene, options), by_distance));
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    PipelineOptions edges = test_options(detection);
    edges.motion_margin = 1.0F;
    edges.features.vertex_triangle = detection == Detection::ccd;
    const std::vector<Contact> found = detect_once(scene, edges);
    edges.contact_rule = ContactRule::ahead;
    EXPECT_TRUE(identical(detect_once(scene, edges), found));
  }
}

}  // namespace
}  // namespace softcd::test
