#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "box_sweep.hpp"
#include "brute_force.hpp"
#include "exact_ccd.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"
#include "reference_distance.hpp"
#include "scene_geometry.hpp"

// Tests the oracles that the other tests of this folder trust.
namespace softcd::test {
namespace {

TEST(BoxSweep, visits_every_overlapping_pair_once) {
  Random random(1);
  std::vector<SweepBox> a;
  std::vector<SweepBox> b;
  for (int i = 0; i < 300; ++i) {
    const Vec3d p = random.in_box(3.0);
    const Vec3d q = random.in_box(3.0);
    a.push_back(enclosing({p, p + random.in_box(i % 10 == 0 ? 5.0 : 0.3)}));
    b.push_back(enclosing({q, q + random.in_box(0.3)}, i % 3 == 0 ? 0.1 : 0.0));
  }
  b.push_back(a[7]);
  std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size(); ++j) {
      if (overlap(a[i], b[j])) expected.insert({i, j});
    }
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> visited;
  for_each_overlap(a, b, [&](std::uint32_t i, std::uint32_t j) {
    EXPECT_TRUE(visited.insert({i, j}).second) << "visited twice";
  });
  EXPECT_EQ(visited, expected);
  EXPECT_GT(expected.size(), 100U);
}

/// Random points, some of them repeated, collinear or coplanar.
std::array<Vec3d, 4> four_points(Random& random) {
  std::array<Vec3d, 4> p{random.in_box(1.0), random.in_box(1.0), random.in_box(1.0), random.in_box(1.0)};
  switch (random.below(6)) {
    case 0:
      p[3] = p[2];
      break;
    case 1:
      p[2] = p[3] = p[1];
      break;
    case 2:
      p[3] = lerp(p[1], p[2], random.uniform(-1.0, 2.0));
      break;
    case 3:
      p[3] = p[2] + (p[1] - p[0]);
      break;
    case 4:
      p[2] = p[1] + 1e-6 * random.direction();
      break;
    default:
      break;
  }
  return p;
}

TEST(ReferenceDistance, is_the_exact_one) {
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const std::array<Vec3d, 4> p = four_points(random);
    ASSERT_NEAR(static_cast<double>(distance_vertex_triangle(p[0], p[1], p[2], p[3])),
                std::sqrt(squared_distance_vertex_triangle(p)), 1e-12);
    ASSERT_NEAR(static_cast<double>(distance_edge_edge(p[0], p[1], p[2], p[3])),
                std::sqrt(squared_distance_edge_edge(p)), 1e-12);
  }
}

TEST(Compare, tells_missed_extra_and_repeated) {
  const auto pair = [](std::uint32_t i) { return FeaturePair{ContactKind::edge_edge, 0, i, 1, 2 * i}; };
  const Verdicts verdicts{{pair(1), pair(2), pair(3)}, {pair(8), pair(9)}};
  EXPECT_TRUE(agrees(compare(verdicts, {pair(3), pair(9), pair(1), pair(2)})));
  const Difference difference = compare(verdicts, {pair(5), pair(1), pair(3), pair(3)});
  EXPECT_EQ(difference.missed, std::vector<FeaturePair>{pair(2)});
  EXPECT_EQ(difference.extra, std::vector<FeaturePair>{pair(5)});
  EXPECT_EQ(difference.repeated, std::vector<FeaturePair>{pair(3)});
}

// A vertex 0.25 above a triangle, and two edges that cross at that distance.
TEST(Verdicts, at_and_around_the_threshold) {
  const Mesh floor{{{{0, 1, 2}}}, {{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}};
  const Mesh point{{{{0, 0, 0}}}, {{0, 0, 0.25}}};
  for (const auto& [margin, certain, undecided] :
       {std::tuple(0.2F, 0U, 0U), std::tuple(0.25F, 0U, 1U), std::tuple(0.3F, 1U, 0U)}) {
    const Verdicts verdicts = discrete_verdicts({still(floor, everything(margin)), still(point, everything())});
    EXPECT_EQ(verdicts.certain.size(), certain);
    EXPECT_EQ(verdicts.undecided.size(), undecided);
  }
  EXPECT_TRUE(continuous_verdicts({still(floor, everything()), still(point, everything())}).certain.empty());
  EXPECT_EQ(continuous_verdicts({still(floor, everything()), moving(point, {{0, 0, 0}}, everything())}).certain.size(),
            1U);
}

TEST(Flaws, of_a_contact_are_found) {
  const Mesh floor{{{{0, 1, 2}}}, {{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}};
  const Mesh point{{{{0, 0, 0}}}, {{0, 0, 0.25}}};
  const Scene scene{still(floor, everything()), still(point, everything(1.0F))};
  const SceneGeometry geometry(scene);
  Contact good{};
  good.kind = ContactKind::vertex_triangle;
  good.body_a = BodyId{1};
  good.body_b = BodyId{0};
  std::copy_n(std::array<std::uint32_t, 4>{0, 0, 1, 2}.begin(), 4, good.vertices);
  std::copy_n(std::array<float, 4>{1.0F, 1.0F / 3, 1.0F / 3, 1.0F / 3}.begin(), 4, good.weights);
  good.normal = {0.0F, 0.0F, 1.0F};
  good.distance = 0.25F;
  good.time_of_impact = 1.0F;
  const auto flaw = [&](const auto& spoil) {
    Contact contact = good;
    spoil(contact);
    return geometry.flaw_of(contact, Detection::dcd, 1e-6);
  };
  EXPECT_EQ(flaw([](Contact&) {}), "");
  EXPECT_NE(flaw([](Contact& c) { c.vertices[2] = 2; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.weights[1] += 0.01F; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.weights[1] = 1.2F, c.weights[2] = -0.2F, c.weights[3] = 0.0F; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.normal.z = 0.9F; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.normal.z = -1.0F; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.normal = {0.0F, 1.0F, 0.0F}; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.distance = 0.26F; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.time_of_impact = 0.5F; }), "");
  EXPECT_NE(flaw([](Contact& c) { c.distance = NAN; }), "");
}

TEST(Generators, snapped_positions_survive_float32_about_another_origin) {
  SoupOptions options;
  options.half_extent = 10.0;
  const Mesh mesh = triangle_soup(options);
  const Vec3d origin{0.5 * (mesh.positions[0].x + mesh.positions[1].x), 3.0, -2.5};
  for (const Vec3d& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      const double relative = p[axis] - origin[axis];
      volatile float narrow = static_cast<float>(relative);
      ASSERT_EQ(static_cast<double>(narrow), relative);
    }
  }
}

TEST(Generators, surfaces_are_closed) {
  for (const Mesh& mesh : {icosphere(2, 1.0), torus(2.0, 0.5, 24, 12)}) {
    EXPECT_EQ(2 * edges_of(mesh.triangles).size(), 3 * mesh.triangles.size());
  }
  EXPECT_EQ(icosphere(2, 1.0).triangles.size(), 320U);
}

}  // namespace
}  // namespace softcd::test
