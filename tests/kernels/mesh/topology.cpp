#include "softcd/mesh/topology.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "mesh_generators.hpp"
#include "random.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::test {
namespace {

using Ends = std::pair<std::uint32_t, std::uint32_t>;

Topology topology_of(const Mesh& mesh) {
  return build_topology(mesh.triangles, static_cast<std::uint32_t>(mesh.positions.size()));
}

Mesh tangled_soup(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 600;
  options.joined_share = 0.7;
  options.degenerate_share = 0.2;
  options.seed = seed;
  return triangle_soup(options);
}

std::vector<Mesh> meshes() {
  Mesh doubled = torus(2.0, 0.5, 20, 10);
  doubled = Mesh{doubled.triangles, doubled.positions};
  doubled.triangles.insert(doubled.triangles.end(), doubled.triangles.begin(), doubled.triangles.begin() + 50);
  return {Mesh{},
          Mesh{{{{0, 1, 2}}}, Positions3(3)},
          Mesh{{{{0, 0, 0}}, {{1, 1, 0}}}, Positions3(5)},
          grid_cloth(12, 9, 1.0),
          icosphere(2, 1.0),
          tube(1.0, 2.0, 9, 7),
          doubled,
          tangled_soup(1),
          tangled_soup(2)};
}

/// Returns every side of every triangle in `wanted`, by the simplest method.
std::map<Ends, std::uint32_t> sides_of(const std::vector<Triangle>& triangles,
                                       const std::vector<std::uint8_t>& left_out) {
  std::map<Ends, std::uint32_t> sides;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (left_out[t] != 0) continue;
    const auto [a, b, c] = triangles[t].v;
    for (const Ends& side : {Ends(a, b), Ends(b, c), Ends(c, a)}) {
      if (side.first != side.second) ++sides[std::minmax(side.first, side.second)];
    }
  }
  return sides;
}

TEST(Topology, edges_are_every_side_once_in_order) {
  for (const Mesh& mesh : meshes()) {
    const Topology topology = topology_of(mesh);
    const std::map<Ends, std::uint32_t> expected =
        sides_of(mesh.triangles, std::vector<std::uint8_t>(mesh.triangles.size(), 0));
    ASSERT_EQ(topology.edges.size(), expected.size());
    std::size_t i = 0;
    for (const auto& [ends, count] : expected) {
      EXPECT_EQ(topology.edges[i].v[0], ends.first);
      EXPECT_EQ(topology.edges[i].v[1], ends.second);
      ++i;
    }
  }
}

TEST(Topology, triangles_know_their_edges) {
  for (const Mesh& mesh : meshes()) {
    const Topology topology = topology_of(mesh);
    ASSERT_EQ(topology.triangle_edges.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int side = 0; side < 3; ++side) {
        const Ends ends = std::minmax(mesh.triangles[t].v[side], mesh.triangles[t].v[(side + 1) % 3]);
        const std::uint32_t edge = topology.triangle_edges[t].e[side];
        if (ends.first == ends.second) {
          EXPECT_EQ(edge, kNoIndex);
        } else {
          ASSERT_LT(edge, topology.edges.size());
          EXPECT_EQ(Ends(topology.edges[edge].v[0], topology.edges[edge].v[1]), ends);
        }
      }
    }
  }
}

TEST(Topology, segments_follow_on_triangles_and_their_edges) {
  const std::vector<Triangle> triangles = {{{2, 1, 0}}};
  const std::vector<Segment> segments = {{{4, 3}}, {{1, 2}}, {{3, 4}}, {{5, 5}}, {{0, 3}}};
  const Topology topology = build_topology(triangles, 6, segments);
  EXPECT_EQ(topology.segment_count, 5U);
  std::vector<Ends> edges;
  for (const Edge& edge : topology.edges) edges.emplace_back(edge.v[0], edge.v[1]);
  EXPECT_EQ(edges, (std::vector<Ends>{{0, 1}, {0, 2}, {1, 2}, {3, 4}, {0, 3}}));
  const std::uint32_t edge_of[] = {3, 2, 3, kNoIndex, 4};
  const unsigned owned[] = {0b001011, 0, 0, 0b000001, 0b001000};
  for (std::size_t s = 0; s < segments.size(); ++s) {
    EXPECT_EQ(topology.triangles[1 + s].v[0], segments[s].v[0]);
    EXPECT_EQ(topology.triangles[1 + s].v[1], segments[s].v[1]);
    EXPECT_EQ(topology.triangles[1 + s].v[2], segments[s].v[1]);
    EXPECT_EQ(topology.triangle_edges[1 + s].e[0], edge_of[s]);
    EXPECT_EQ(topology.ownership[1 + s], owned[s] | kSegment) << "segment " << s;
  }
  EXPECT_EQ(topology.ownership[0], 63U);
}

void expect_each_feature_owned_once(const Topology& topology, const std::vector<Ownership>& ownership,
                                    const std::vector<std::uint8_t>& left_out) {
  std::vector<int> vertex_owners(topology.vertex_count, 0);
  std::vector<int> edge_owners(topology.edges.size(), 0);
  std::vector<bool> vertex_occurs(topology.vertex_count, false);
  ASSERT_EQ(ownership.size(), topology.triangles.size());
  for (std::size_t t = 0; t < ownership.size(); ++t) {
    if (left_out[t] != 0) {
      EXPECT_EQ(ownership[t] & 63U, 0U);
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t vertex = topology.triangles[t].v[i];
      vertex_occurs[vertex] = true;
      if ((ownership[t] >> i) & 1U) ++vertex_owners[vertex];
      if ((ownership[t] >> (3 + i)) & 1U) {
        ASSERT_NE(topology.triangle_edges[t].e[i], kNoIndex);
        ++edge_owners[topology.triangle_edges[t].e[i]];
      }
    }
  }
  const std::map<Ends, std::uint32_t> sides = sides_of(topology.triangles, left_out);
  for (std::uint32_t v = 0; v < topology.vertex_count; ++v) EXPECT_EQ(vertex_owners[v], vertex_occurs[v] ? 1 : 0);
  for (std::size_t e = 0; e < topology.edges.size(); ++e) {
    const Ends ends(topology.edges[e].v[0], topology.edges[e].v[1]);
    EXPECT_EQ(edge_owners[e], sides.contains(ends) ? 1 : 0);
  }
}

TEST(Ownership, every_vertex_and_edge_has_one_owner) {
  for (const Mesh& mesh : meshes()) {
    const Topology topology = topology_of(mesh);
    expect_each_feature_owned_once(topology, topology.ownership, std::vector<std::uint8_t>(mesh.triangles.size(), 0));
  }
}

TEST(Ownership, passes_on_from_triangles_that_are_left_out) {
  Random random(3);
  for (const Mesh& mesh : meshes()) {
    const Topology topology = topology_of(mesh);
    for (const double share : {0.05, 0.5, 1.0}) {
      std::vector<std::uint8_t> left_out;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) left_out.push_back(random.chance(share) ? 1 : 0);
      expect_each_feature_owned_once(topology, assign_ownership(view_of(topology), left_out), left_out);
    }
  }
}

bool share_vertex(const Topology& topology, std::uint32_t a, std::uint32_t b) {
  const auto& v = topology.triangles[b].v;
  return std::any_of(topology.triangles[a].v, topology.triangles[a].v + 3,
                     [&](std::uint32_t vertex) { return std::find(v, v + 3, vertex) != v + 3; });
}

/// Returns the owners of the vertices, or of the edges; kNoIndex where a feature has none.
std::vector<std::uint32_t> owners(const Topology& topology, const std::vector<Ownership>& ownership, bool of_edges) {
  std::vector<std::uint32_t> owner(of_edges ? topology.edges.size() : topology.vertex_count, kNoIndex);
  for (std::uint32_t t = 0; t < ownership.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      if (((ownership[t] >> (of_edges ? 3 + i : i)) & 1U) == 0) continue;
      owner[of_edges ? topology.triangle_edges[t].e[i] : topology.triangles[t].v[i]] = t;
    }
  }
  return owner;
}

/// Finds neighbours' features by comparing every vertex with every triangle, and every edge with every other one.
NeighbourFeatures neighbours_by_trial(const Topology& topology, const std::vector<Ownership>& ownership) {
  NeighbourFeatures out;
  const std::vector<std::uint32_t> vertex_owner = owners(topology, ownership, false);
  const std::vector<std::uint32_t> edge_owner = owners(topology, ownership, true);
  for (std::uint64_t v = 0; v < vertex_owner.size(); ++v) {
    for (std::uint32_t t = 0; t < ownership.size(); ++t) {
      const auto& corners = topology.triangles[t].v;
      if (vertex_owner[v] == kNoIndex || (ownership[t] & kLeftOut) != 0) continue;
      if (std::find(corners, corners + 3, v) != corners + 3) continue;
      if (share_vertex(topology, vertex_owner[v], t)) out.vertex_triangle.push_back((v << 32) | t);
    }
  }
  for (std::uint64_t e = 0; e < edge_owner.size(); ++e) {
    for (std::uint32_t g = static_cast<std::uint32_t>(e) + 1; g < edge_owner.size(); ++g) {
      const auto [p, q] = topology.edges[e].v;
      const auto [r, s] = topology.edges[g].v;
      if (edge_owner[e] == kNoIndex || edge_owner[g] == kNoIndex || p == r || p == s || q == r || q == s) continue;
      if (share_vertex(topology, edge_owner[e], edge_owner[g])) out.edge_edge.push_back((e << 32) | g);
    }
  }
  return out;
}

TEST(Neighbours, everything_at_triangles_that_share_a_vertex_is_listed_once) {
  Random random(4);
  std::size_t listed = 0;
  for (const Mesh& mesh : meshes()) {
    const Topology topology = topology_of(mesh);
    for (const double share : {0.0, 0.1}) {
      std::vector<std::uint8_t> left_out;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) left_out.push_back(random.chance(share) ? 1 : 0);
      std::vector<Ownership> ownership = assign_ownership(view_of(topology), left_out);
      for (std::size_t t = 0; t < left_out.size(); ++t) {
        if (left_out[t] != 0) ownership[t] = static_cast<Ownership>(kLeftOut);
      }
      NeighbourFeatures features = neighbour_features(view_of(topology), ownership);
      if (!features.are_listed) continue;  // no lists of tangles, as their triangles meet in few vertices
      std::sort(features.vertex_triangle.begin(), features.vertex_triangle.end());
      std::sort(features.edge_edge.begin(), features.edge_edge.end());
      const NeighbourFeatures expected = neighbours_by_trial(topology, ownership);
      EXPECT_EQ(features.vertex_triangle, expected.vertex_triangle);
      EXPECT_EQ(features.edge_edge, expected.edge_edge);
      listed += features.vertex_triangle.size() + features.edge_edge.size();
    }
  }
  EXPECT_GT(listed, 10000U);
}

TEST(Neighbours, are_not_listed_where_there_are_too_many) {
  Mesh fan{{}, Positions3(202)};
  for (std::uint32_t i = 1; i <= 200; ++i) fan.triangles.push_back({{0, i, i + 1}});
  const Topology topology = topology_of(fan);
  const NeighbourFeatures features = neighbour_features(view_of(topology), topology.ownership);
  EXPECT_FALSE(features.are_listed);
  EXPECT_TRUE(features.vertex_triangle.empty());
  EXPECT_TRUE(features.edge_edge.empty());
}

// Triangles are listed some thousands at a time; ends count from the first of all.
TEST(Neighbours, of_each_triangle_end_where_those_of_the_next_begin) {
  const Topology topology = topology_of(grid_cloth(66, 66, 1.0));
  ASSERT_GT(topology.triangles.size(), 8192U);
  std::vector<FeatureEnds> ends;
  const NeighbourFeatures features = neighbour_features(view_of(topology), topology.ownership, &ends);
  const std::vector<std::uint32_t> vertex_owner = owners(topology, topology.ownership, false);
  const std::vector<std::uint32_t> edge_owner = owners(topology, topology.ownership, true);
  ASSERT_EQ(ends.size(), topology.triangles.size());
  FeatureEnds begin{};
  for (std::uint32_t t = 0; t < ends.size(); ++t) {
    for (std::uint32_t i = begin.vertex_triangle; i < ends[t].vertex_triangle; ++i) {
      const std::uint64_t feature = features.vertex_triangle[i];
      ASSERT_TRUE(vertex_owner[feature >> 32] == t || static_cast<std::uint32_t>(feature) == t) << t;
    }
    for (std::uint32_t i = begin.edge_edge; i < ends[t].edge_edge; ++i) {
      const std::uint64_t edges = features.edge_edge[i];
      ASSERT_TRUE(edge_owner[edges >> 32] == t || edge_owner[static_cast<std::uint32_t>(edges)] == t) << t;
    }
    begin = ends[t];
  }
  EXPECT_EQ(begin.vertex_triangle, features.vertex_triangle.size());
  EXPECT_EQ(begin.edge_edge, features.edge_edge.size());
}

}  // namespace
}  // namespace softcd::test
