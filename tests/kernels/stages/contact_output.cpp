#include "softcd/stages/contact_output.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

TEST(ContactKeys, kind_and_features_survive_packing) {
  for (const ContactKind kind : {ContactKind::vertex_triangle, ContactKind::edge_edge}) {
    const std::uint64_t features = with_kind(kind, (0x7FFFFFFFULL << 32) | 0xFFFFFFFEULL);
    EXPECT_EQ(kind_of(features), kind);
    EXPECT_EQ(first_feature(features), 0x7FFFFFFFU);
    EXPECT_EQ(second_feature(features), 0xFFFFFFFEU);
  }
}

// However few bits the scene needs: keys order contacts as kind, first and second feature do.
TEST(ContactKeys, sort_as_kind_and_features) {
  Random random(1);
  for (const auto& [first_bits, second_bits] : {std::pair(1U, 1U), std::pair(5U, 9U), std::pair(31U, 32U)}) {
    std::vector<FeatureContact> contacts(300);
    for (FeatureContact& contact : contacts) {
      const std::uint64_t first = random.bits() & ((1ULL << std::min(first_bits, 31U)) - 1U);
      const std::uint64_t second = random.bits() & ((1ULL << second_bits) - 1U);
      contact.features = with_kind(static_cast<ContactKind>(random.below(2)), (first << 32) | second);
    }
    std::vector<std::uint64_t> keys(contacts.size());
    std::vector<std::uint32_t> order(contacts.size());
    const MakeContactKey stage{contacts.data(), first_bits, second_bits, keys.data(), order.data()};
    for (std::uint32_t i = 0; i < contacts.size(); ++i) stage(i);
    const auto rank = [&](std::size_t i) {
      const std::uint64_t features = contacts[i].features;
      return std::tuple(kind_of(features), first_feature(features), second_feature(features));
    };
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      ASSERT_EQ(order[i], i);
      for (std::size_t j = 0; j < contacts.size(); ++j) ASSERT_EQ(keys[i] < keys[j], rank(i) < rank(j));
    }
  }
}

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
  const WriteContact stage{scene, found, order, out};
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
