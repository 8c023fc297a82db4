#include "softcd/stages/contact_output.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host_scene.hpp"

namespace softcd::test {
namespace {

TEST(WriteContact, indices_count_within_the_bodies) {
  const Mesh square = grid_cloth(2, 2, 1.0);
  const HostScene host({{square, {}}, {square, {}}, {square, {}}}, false);
  SceneView scene = host.view();
  // Edges of a square of two triangles: 0-1, 0-2, 0-3, 1-3, 2-3.
  const std::uint64_t vertex_and_triangle = with_kind(ContactKind::vertex_triangle, (9ULL << 32) | 3ULL);
  const std::uint64_t two_edges = with_kind(ContactKind::edge_edge, (4ULL << 32) | 11ULL);
  const FeatureContact found[] = {{two_edges, {0.25F, 0.75F, 0.5F, 0.5F}, {0, 1, 0}, 0.5F, 0.125F, 0U},
                                  {vertex_and_triangle, {1.0F, 0.5F, 0.25F, 0.25F}, {0, 0, 1}, 0.75F, 1.0F, 0U}};
  const std::uint32_t order[] = {1, 0};
  Contact out[2];
  const WriteInOrder stage{{scene, out}, found, order};
  stage(0);
  stage(1);

  EXPECT_EQ(out[0].kind, ContactKind::vertex_triangle);
  EXPECT_EQ(out[0].body_a, BodyId{2});
  EXPECT_EQ(out[0].feature_a, 1U);
  EXPECT_EQ(out[0].body_b, BodyId{1});
  EXPECT_EQ(out[0].feature_b, 1U);
  const Triangle triangle = square.triangles[1];
  EXPECT_TRUE(std::equal(triangle.v, triangle.v + 3, out[0].vertices + 1));
  EXPECT_EQ(out[0].vertices[0], 1U);
  EXPECT_EQ(out[0].distance, 0.75F);

  EXPECT_EQ(out[1].kind, ContactKind::edge_edge);
  EXPECT_EQ(out[1].body_a, BodyId{0});
  EXPECT_EQ(out[1].feature_a, 4U);
  EXPECT_EQ(out[1].body_b, BodyId{2});
  EXPECT_EQ(out[1].feature_b, 1U);
  const std::uint32_t edges[] = {2, 3, 0, 2};
  EXPECT_TRUE(std::equal(edges, edges + 4, out[1].vertices));
  EXPECT_EQ(out[1].time_of_impact, 0.125F);
  EXPECT_EQ(out[1].weights[1], 0.75F);
}

}  // namespace
}  // namespace softcd::test
