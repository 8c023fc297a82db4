#include "softcd/stages/slab_reach.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "host_scene.hpp"
#include "softcd/stages/contact_tests.hpp"

namespace softcd::test {
namespace {

Mesh soup_with_needles(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 600;
  options.half_extent = 0.5;
  options.size_ratio = 20.0;
  options.needle_share = 0.1;
  options.degenerate_share = 0.1;
  options.seed = seed;
  return triangle_soup(options);
}

/// Two bodies whose margins are small compared with some of their triangles, and large compared with others.
HostScene two_soups() {
  return HostScene({{soup_with_needles(1), {}, 0.02F, false}, {soup_with_needles(2), {}, 0.03F, false}},
                   /*continuous=*/false);
}

std::vector<SlabReach> reaches_of(const SceneView& scene, const HostVolumes& bounds) {
  std::vector<SlabReach> reaches(scene.triangle_count);
  const MeasureSlab measure{scene, bounds.volumes.data(), reaches.data()};
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) measure(t);
  return reaches;
}

/// Returns the features of a triangle and another that may be in contact.
struct FeaturesOfPair {
  std::vector<std::uint64_t> vertex_triangle, edge_edge;

  FeaturesOfPair(const SceneView& scene, std::uint32_t a, std::uint32_t b) {
    const auto join = [](std::uint32_t first, std::uint32_t second) { return (std::uint64_t{first} << 32) | second; };
    for (const std::uint32_t v : scene.triangles[a].v) vertex_triangle.push_back(join(v, b));
    for (const std::uint32_t v : scene.triangles[b].v) vertex_triangle.push_back(join(v, a));
    for (const std::uint32_t e : scene.triangle_edges[a].e) {
      for (const std::uint32_t f : scene.triangle_edges[b].e) {
        if (e != kNoIndex && f != kNoIndex) edge_edge.push_back(join(e, f));
      }
    }
  }
};

// The narrow phase finds no contact between triangles that are left out.
TEST(SlabReaches, leave_out_no_contact) {
  const HostScene host = two_soups();
  SceneView scene = host.view();
  scene.contact_rule = ContactRule::slab;
  const HostVolumes bounds(scene);
  const std::vector<SlabReach> reaches = reaches_of(scene, bounds);
  std::size_t left_out = 0;
  std::size_t in_contact = 0;
  for (std::uint32_t a = 0; a < scene.triangle_count; ++a) {
    for (std::uint32_t b = a + 1; b < scene.triangle_count; ++b) {
      if (scene.triangle_body[a] == scene.triangle_body[b] || !overlap(bounds.volumes[a], bounds.volumes[b])) continue;
      const float growth = bounds.shapes[a].growth + bounds.shapes[b].growth;
      const bool is_left_out =
          certainly_beyond_slabs(bounds.volumes[a], bounds.volumes[b], growth, reaches[a], reaches[b]);
      Collector<FeatureContact> contacts;
      const FeaturesOfPair features(scene, a, b);
      const TestSlab<double> by_slab{scene, features.vertex_triangle.data()};
      for (std::uint32_t i = 0; i < features.vertex_triangle.size(); ++i) by_slab(i, contacts);
      const TestProximity<ContactKind::edge_edge, double> by_distance{scene, features.edge_edge.data()};
      for (std::uint32_t i = 0; i < features.edge_edge.size(); ++i) by_distance(i, contacts);
      EXPECT_TRUE(contacts.items.empty() || !is_left_out) << a << " and " << b;
      left_out += is_left_out ? 1 : 0;
      in_contact += contacts.items.empty() ? 0 : 1;
    }
  }
  EXPECT_GT(in_contact, 500U);
  EXPECT_GT(left_out, 500U);
}

// A slab reaches one margin along the normal, and margin / sqrt(area) times the triangle's extent along its sides, at
// most sqrt(5) margins.
TEST(SlabReaches, are_one_margin_along_the_normal) {
  const Vec3f flat[3] = {{0.0F, 0.0F, 1.0F}, {1.0F, 0.0F, 1.0F}, {0.0F, 2.0F, 1.0F}};
  const SlabReach reach = MeasureSlab::reach_of(flat);
  const float margin = 1.0F / kSlabFactor;
  EXPECT_NEAR(reach.share[0], margin, 1e-3F) << "the extent is 1, and so is the area";
  EXPECT_NEAR(reach.share[1], 2.0F * margin, 1e-3F);
  EXPECT_NEAR(reach.share[2], margin, 1e-3F);
  // Beside a long side, contacts of edges reach farther.
  const Vec3f needle[3] = {{0.0F, 0.0F, 1.0F}, {100.0F, 0.0F, 1.0F}, {0.0F, 1.0F, 1.0F}};
  EXPECT_GT(MeasureSlab::reach_of(needle).share[1], margin);
  const Vec3f segment[3] = {{0.0F, 0.0F, 1.0F}, {1.0F, 0.0F, 1.0F}, {2.0F, 0.0F, 1.0F}};
  for (const float share : MeasureSlab::reach_of(segment).share) EXPECT_EQ(share, 1.0F);
}

}  // namespace
}  // namespace softcd::test
