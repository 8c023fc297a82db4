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

/// The indices of the edges that triangles have.
std::map<Ends, std::uint32_t> edges_of(const Topology& mesh) {
  std::map<Ends, std::uint32_t> edges;
  for (std::uint32_t e = 0; e < mesh.edges.size(); ++e) {
    if (mesh.edges[e].v[0] == mesh.edges[e].v[1]) continue;
    EXPECT_TRUE(edges.emplace(ends_of(mesh.edges[e]), e).second) << "an edge is there twice";
  }
  return edges;
}

/// But for the edges' order.
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

/// What each triangle lists, sorted.
std::vector<std::vector<std::uint64_t>> neighbours_of(const ChangingMesh& changing) {
  const Topology& topology = changing.topology();
  const MeshView mesh = view_of(topology);
  std::vector<std::vector<std::uint64_t>> all;
  for (std::uint32_t t = 0; t < topology.triangles.size(); ++t) {
    NeighbourFeatures features;
    NeighbourLister lister(mesh, topology.ownership, features);
    for_each_neighbour(mesh, changing, t, [&](std::uint32_t n) { lister.add(t, n); });
    std::vector<std::uint64_t> both = features.vertex_triangle;
    both.push_back(kNoFeatures);
    std::sort(features.edge_edge.begin(), features.edge_edge.end());
    std::sort(both.begin(), both.end());
    both.insert(both.end(), features.edge_edge.begin(), features.edge_edge.end());
    all.push_back(std::move(both));
  }
  return all;
}

/// Whatever is not named as changed, or stale, is as it was.
void expect_named(const Topology& before, const std::vector<std::vector<std::uint64_t>>& neighbours_before,
                  const ChangingMesh& changing) {
  const Topology& now = changing.topology();
  const auto is_in = [](Span<const std::uint32_t> indices, std::uint32_t index) {
    return std::find(indices.begin(), indices.end(), index) != indices.end();
  };
  const std::vector<std::vector<std::uint64_t>> neighbours = neighbours_of(changing);
  const std::size_t most = std::max(before.triangles.size(), now.triangles.size());
  for (std::uint32_t t = 0; t < most; ++t) {
    const bool is_in_both = t < std::min(before.triangles.size(), now.triangles.size());
    if (!is_in(changing.changed_triangles(), t)) {
      ASSERT_TRUE(is_in_both) << t;
      EXPECT_TRUE(same(before.triangles[t], now.triangles[t])) << t;
      EXPECT_TRUE(std::equal(now.triangle_edges[t].e, now.triangle_edges[t].e + 3, before.triangle_edges[t].e)) << t;
      EXPECT_EQ(before.ownership[t], now.ownership[t]) << t;
    }
    if (is_in(changing.stale_triangles(), t)) continue;
    ASSERT_TRUE(is_in_both) << t;
    EXPECT_EQ(neighbours[t], neighbours_before[t]) << t;
  }
  for (std::uint32_t e = 0; e < std::max(before.edges.size(), now.edges.size()); ++e) {
    if (is_in(changing.changed_edges(), e)) continue;
    ASSERT_LT(e, std::min(before.edges.size(), now.edges.size()));
    EXPECT_EQ(ends_of(before.edges[e]), ends_of(now.edges[e]));
  }
}

/// From one change to the next.
void expect_edges_kept(const Topology& before, const Topology& now) {
  const std::map<Ends, std::uint32_t> edges_now = edges_of(now);
  for (const auto& [ends, e] : edges_of(before)) {
    const auto stayed = edges_now.find(ends);
    EXPECT_TRUE(stayed == edges_now.end() || stayed->second == e);
  }
}

/// Makes a mesh another one; returns which triangles are others.
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
    const std::uint32_t near = random_.below(mesh.vertex_count);
    for (std::uint32_t& v : triangle.v) v = (near + random_.below(5)) % mesh.vertex_count;
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
      changing.forget_stale();
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
        expect_named(before, neighbours_before, changing);
        changing.forget_changes();
        changing.forget_stale();
        EXPECT_TRUE(changing.changed_triangles().empty() && changing.changed_edges().empty() &&
                    !changing.has_changes());
      }
    }
  }
}

// Triangles that are not said to have changed are not read.
TEST(ChangingMesh, reads_what_has_changed) {
  Changed now = changed_of(grid_cloth(5, 5, 1.0));
  ChangingMesh changing(build_topology(now.triangles, now.vertex_count));
  std::vector<Triangle> others(now.triangles.size(), Triangle{{kNoIndex, kNoIndex, kNoIndex}});
  others[7] = now.triangles[7] = {{3, 9, 20}};
  const std::vector<std::uint32_t> changed{7, 7};
  changing.change(others, now.vertex_count, changed);
  expect_topology_of(now, changing);
}

// What lies far from a change is not touched.
TEST(ChangingMesh, costs_what_has_changed) {
  Changed now = changed_of(grid_cloth(100, 100, 1.0));
  ChangingMesh changing(build_topology(now.triangles, now.vertex_count));
  changing.forget_stale();
  std::swap(now.triangles[5000].v[0], now.triangles[5001].v[0]);
  const std::vector<std::uint32_t> changed{5000, 5001};
  changing.change(now.triangles, now.vertex_count, changed);
  EXPECT_LT(changing.changed_triangles().size(), 20U);
  EXPECT_LT(changing.changed_edges().size(), 10U);
  EXPECT_LT(changing.stale_triangles().size(), 80U);
  EXPECT_GT(changing.stale_triangles().size(), 10U);
}

}  // namespace
}  // namespace softcd::test
