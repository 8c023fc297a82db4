#include "softcd/mesh/changing_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh_generators.hpp"
#include "random.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/neighbour_lister.hpp"

namespace softcd::test {
namespace {

using Ends = std::pair<std::uint32_t, std::uint32_t>;

struct Changed {
  std::vector<Triangle> triangles;
  std::uint32_t vertex_count;
};

Ends ends_of(const Edge& edge) {
  return {edge.v[0], edge.v[1]};
}

bool same(const Triangle& a, const Triangle& b) {
  return std::equal(a.v, a.v + 3, b.v);
}

/// Returns the indices of the edges that triangles have.
std::map<Ends, std::uint32_t> edges_of(const Topology& mesh) {
  std::map<Ends, std::uint32_t> edges;
  for (std::uint32_t e = 0; e < mesh.edges.size(); ++e) {
    if (mesh.edges[e].v[0] == mesh.edges[e].v[1]) continue;
    EXPECT_TRUE(edges.emplace(ends_of(mesh.edges[e]), e).second) << "an edge is there twice";
  }
  return edges;
}

/// Expects the wanted topology, except for the edges' order.
void expect_topology_of(const Changed& wanted, const ChangingMesh& changing) {
  const Topology& mesh = changing.topology();
  const Topology expected = build_topology(wanted.triangles, wanted.vertex_count);
  ASSERT_EQ(mesh.vertex_count, expected.vertex_count);
  ASSERT_EQ(mesh.triangles.size(), expected.triangles.size());
  ASSERT_EQ(mesh.triangle_edges.size(), expected.triangles.size());
  EXPECT_EQ(mesh.ownership, expected.ownership);
  const std::map<Ends, std::uint32_t> edges = edges_of(mesh);
  EXPECT_EQ(changing.edge_count(), edges.size());
  ASSERT_EQ(edges.size(), expected.edges.size());
  for (const Edge& edge : expected.edges) EXPECT_EQ(edges.count(ends_of(edge)), 1U);
  for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
    EXPECT_TRUE(same(mesh.triangles[t], expected.triangles[t])) << t;
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t e = expected.triangle_edges[t].e[side];
      const std::uint32_t wanted_edge = e == kNoIndex ? kNoIndex : edges.at(ends_of(expected.edges[e]));
      EXPECT_EQ(mesh.triangle_edges[t].e[side], wanted_edge) << t;
    }
  }
  std::uint64_t corners_around = 0;
  for (std::uint32_t v = 0; v < wanted.vertex_count; ++v) {
    std::set<std::uint32_t> listed;
    changing.for_each_triangle_of(v, [&](std::uint32_t t) { EXPECT_TRUE(listed.insert(t).second); });
    std::set<std::uint32_t> having;
    for (std::uint32_t t = 0; t < wanted.triangles.size(); ++t) {
      if (has_vertex(wanted.triangles[t], v)) having.insert(t);
    }
    EXPECT_EQ(listed, having);
    corners_around += having.size() * having.size();
  }
  EXPECT_EQ(changing.lists_neighbours(), corners_around <= 64 * wanted.triangles.size());
}

/// Pairs of a vertex and a triangle, and pairs of edges, each sorted.
struct Listed {
  std::vector<std::uint64_t> vertex_triangle, edge_edge;

  void sort() {
    std::sort(vertex_triangle.begin(), vertex_triangle.end());
    std::sort(edge_edge.begin(), edge_edge.end());
  }
};

/// Returns each triangle's features with its neighbours.
std::vector<NeighbourFeatures> neighbours_of(const ChangingMesh& changing) {
  const Topology& topology = changing.topology();
  const MeshView mesh = view_of(topology);
  std::vector<NeighbourFeatures> all(topology.triangles.size());
  for (std::uint32_t t = 0; t < topology.triangles.size(); ++t) {
    NeighbourLister lister(mesh, topology.ownership, all[t]);
    for_each_neighbour(mesh, changing, t, [&](std::uint32_t n) { lister.add(t, n); });
  }
  return all;
}

bool is_in(Span<const std::uint32_t> indices, std::uint32_t index) {
  return std::find(indices.begin(), indices.end(), index) != indices.end();
}

Ends high_and_low(std::uint64_t features) {
  return {static_cast<std::uint32_t>(features >> 32), static_cast<std::uint32_t>(features)};
}

/// Keeps those features of a triangle that are not stale; all of them if the triangle is not stale.
void keep(const NeighbourFeatures& features, bool is_stale_triangle, const ChangingMesh& changing, Listed& kept) {
  for (const std::uint64_t pair : features.vertex_triangle) {
    const bool is_stale = changing.is_stale_pair(high_and_low(pair).first, high_and_low(pair).second);
    EXPECT_TRUE(is_stale_triangle || !is_stale);
    if (!is_stale) kept.vertex_triangle.push_back(pair);
  }
  for (const std::uint64_t edges : features.edge_edge) {
    const bool is_stale = changing.are_stale_edges(high_and_low(edges).first, high_and_low(edges).second);
    EXPECT_TRUE(is_stale_triangle || !is_stale);
    if (!is_stale) kept.edge_edge.push_back(edges);
  }
}

/// Expects that the earlier features, without the stale ones and with those of relisted triangles, are the present
/// ones.
void expect_relisted(const std::vector<NeighbourFeatures>& before, const ChangingMesh& changing) {
  Listed found;
  for (std::uint32_t t = 0; t < before.size(); ++t) {
    keep(before[t], is_in(changing.stale_triangles(), t), changing, found);
  }
  const MeshView mesh = view_of(changing.topology());
  NeighbourFeatures added;
  NeighbourLister lister(mesh, changing.topology().ownership, added);
  for (const std::uint32_t t : changing.relisted_triangles()) {
    EXPECT_TRUE(changing.is_relisted(t));
    if (t >= mesh.triangles.size()) continue;
    for_each_neighbour(mesh, changing, t, [&](std::uint32_t n) {
      lister.add(t, n);
      if (!changing.is_relisted(n)) lister.add(n, t);
    });
  }
  found.vertex_triangle.insert(found.vertex_triangle.end(), added.vertex_triangle.begin(), added.vertex_triangle.end());
  found.edge_edge.insert(found.edge_edge.end(), added.edge_edge.begin(), added.edge_edge.end());
  found.sort();
  const NeighbourFeatures anew = neighbour_features(mesh, changing.topology().ownership);
  if (!anew.are_listed) return;
  Listed expected{anew.vertex_triangle, anew.edge_edge};
  expected.sort();
  EXPECT_EQ(found.vertex_triangle, expected.vertex_triangle);
  EXPECT_EQ(found.edge_edge, expected.edge_edge);
}

/// Expects everything that is not reported as changed to be unchanged.
void expect_named(const Topology& before, const ChangingMesh& changing) {
  const Topology& now = changing.topology();
  const std::size_t most = std::max(before.triangles.size(), now.triangles.size());
  for (std::uint32_t t = 0; t < most; ++t) {
    if (is_in(changing.changed_triangles(), t)) continue;
    ASSERT_LT(t, std::min(before.triangles.size(), now.triangles.size()));
    EXPECT_TRUE(same(before.triangles[t], now.triangles[t])) << t;
    EXPECT_TRUE(std::equal(now.triangle_edges[t].e, now.triangle_edges[t].e + 3, before.triangle_edges[t].e)) << t;
    EXPECT_EQ(before.ownership[t], now.ownership[t]) << t;
  }
  for (std::uint32_t e = 0; e < std::max(before.edges.size(), now.edges.size()); ++e) {
    if (is_in(changing.changed_edges(), e)) continue;
    ASSERT_LT(e, std::min(before.edges.size(), now.edges.size()));
    EXPECT_EQ(ends_of(before.edges[e]), ends_of(now.edges[e]));
  }
}

/// Expects remaining edges to keep their indices.
void expect_edges_kept(const Topology& before, const Topology& now) {
  const std::map<Ends, std::uint32_t> edges_now = edges_of(now);
  for (const auto& [ends, e] : edges_of(before)) {
    const auto stayed = edges_now.find(ends);
    EXPECT_TRUE(stayed == edges_now.end() || stayed->second == e);
  }
}

/// Changes a mesh, and returns the changed triangles.
class Changer {
 public:
  explicit Changer(std::uint64_t seed) : random_(seed) {}

  std::vector<std::uint32_t> change(Changed& mesh) {
    std::vector<std::uint32_t> changed;
    const auto all = static_cast<std::uint32_t>(mesh.triangles.size());
    mesh.vertex_count += random_.below(3);
    if (random_.chance(0.4)) {
      mesh.triangles.resize(all - random_.below(all / 4 + 1));
    } else {
      for (std::uint32_t added = random_.below(6); added > 0; --added) mesh.triangles.push_back(some_triangle(mesh));
    }
    const std::uint32_t rest = std::min(all, static_cast<std::uint32_t>(mesh.triangles.size()));
    for (std::uint32_t n = rest == 0 ? 0 : random_.below(6); n > 0; --n) {
      const std::uint32_t t = random_.below(rest);
      changed.push_back(t);
      mesh.triangles[t] = random_.chance(0.3) ? mesh.triangles[random_.below(rest)] : some_triangle(mesh);
      if (random_.chance(0.2)) std::rotate(mesh.triangles[t].v, mesh.triangles[t].v + 1, mesh.triangles[t].v + 3);
    }
    if (random_.chance(0.3)) remove_last_vertex(mesh, rest, changed);
    return changed;
  }

 private:
  Triangle some_triangle(const Changed& mesh) {
    Triangle triangle{};
    const std::uint32_t nearby = random_.below(mesh.vertex_count);
    for (std::uint32_t& v : triangle.v) v = (nearby + random_.below(5)) % mesh.vertex_count;
    return triangle;
  }
  static void remove_last_vertex(Changed& mesh, std::uint32_t rest, std::vector<std::uint32_t>& changed) {
    if (mesh.vertex_count < 2) return;
    --mesh.vertex_count;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!has_vertex(mesh.triangles[t], mesh.vertex_count)) continue;
      std::replace(mesh.triangles[t].v, mesh.triangles[t].v + 3, mesh.vertex_count, mesh.vertex_count - 1);
      if (t < rest) changed.push_back(t);
    }
  }

  Random random_;
};

Changed changed_of(const Mesh& mesh) {
  return {mesh.triangles, static_cast<std::uint32_t>(mesh.positions.size())};
}

TEST(ChangingMesh, is_what_it_would_be_anew_but_for_the_order_of_edges) {
  SoupOptions soup;
  soup.triangle_count = 60;
  soup.joined_share = 0.8;
  soup.degenerate_share = 0.3;
  const std::vector<Mesh> meshes{Mesh{{}, Positions3(1)}, grid_cloth(8, 6, 1.0), icosphere(1, 1.0),
                                 triangle_soup(soup)};
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    for (const Mesh& mesh : meshes) {
      Changed now = changed_of(mesh);
      ChangingMesh changing(build_topology(now.triangles, now.vertex_count));
      changing.forget_relisted();
      Changer changer(seed);
      for (int step = 0; step < 40 && !testing::Test::HasFailure(); ++step) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << mesh.triangles.size() << " triangles, step "
                                        << step);
        const Topology before = changing.topology();
        const auto neighbours_before = neighbours_of(changing);
        for (int together = step % 3; together >= 0; --together) {
          const std::vector<std::uint32_t> changed = changer.change(now);
          const Topology last = changing.topology();
          changing.change(now.triangles, now.vertex_count, changed);
          expect_edges_kept(last, changing.topology());
        }
        EXPECT_TRUE(changing.has_changes());
        expect_topology_of(now, changing);
        expect_named(before, changing);
        expect_relisted(neighbours_before, changing);
        changing.forget_changes();
        changing.forget_relisted();
        EXPECT_TRUE(changing.changed_triangles().empty() && changing.changed_edges().empty() &&
                    !changing.has_changes());
      }
    }
  }
}

// Triangles that are not reported as changed are not read.
TEST(ChangingMesh, reads_what_has_changed) {
  Changed now = changed_of(grid_cloth(5, 5, 1.0));
  ChangingMesh changing(build_topology(now.triangles, now.vertex_count));
  std::vector<Triangle> others(now.triangles.size(), Triangle{{kNoIndex, kNoIndex, kNoIndex}});
  others[7] = now.triangles[7] = {{3, 9, 20}};
  const std::vector<std::uint32_t> changed{7, 7};
  changing.change(others, now.vertex_count, changed);
  expect_topology_of(now, changing);
}

// Elements far from a change are not accessed.
TEST(ChangingMesh, costs_what_has_changed) {
  Changed now = changed_of(grid_cloth(100, 100, 1.0));
  ChangingMesh changing(build_topology(now.triangles, now.vertex_count));
  changing.forget_relisted();
  std::swap(now.triangles[5000].v[0], now.triangles[5001].v[0]);
  const std::vector<std::uint32_t> changed{5000, 5001};
  changing.change(now.triangles, now.vertex_count, changed);
  EXPECT_LT(changing.changed_triangles().size(), 20U);
  EXPECT_LT(changing.changed_edges().size(), 10U);
  EXPECT_LT(changing.relisted_triangles().size(), 20U);
  EXPECT_LT(changing.stale_triangles().size(), 80U);
  EXPECT_GT(changing.stale_triangles().size(), 10U);
}

}  // namespace
}  // namespace softcd::test
