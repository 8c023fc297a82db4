#include "softcd/stages/feature_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "box_sweep.hpp"
#include "exact_ccd.hpp"
#include "host_scene.hpp"
#include "reference_distance.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/stages/pair_tests.hpp"

namespace softcd::test {
namespace {

using Candidates = std::vector<std::uint64_t>;

Mesh tangle(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 100;
  options.half_extent = 1.0;
  options.size_ratio = 10.0;
  options.joined_share = 0.6;
  options.degenerate_share = 0.15;
  options.seed = seed;
  return triangle_soup(options);
}

SweepBox box_of_vertices(const SceneView& scene, std::initializer_list<std::uint32_t> vertices, double reach) {
  SweepBox box = enclosing({vec3_cast<double>(scene.x_t1[*vertices.begin()])});
  for (const std::uint32_t v : vertices) {
    for (const Vec3f* x : {scene.x_t1, scene.is_swept ? scene.x_t0 : scene.x_t1}) {
      box = enclosing({box.low, box.high, vec3_cast<double>(x[v])});
    }
  }
  return enclosing({box.low, box.high}, reach);
}

double margin_of(const SceneView& scene, std::uint32_t v) {
  return static_cast<double>(scene.bodies[scene.vertex_body[v]].margin);
}

bool wants(const SceneView& scene, std::uint32_t body_a, std::uint32_t body_b, bool vertices) {
  const softcd::SceneBody& a = scene.bodies[body_a];
  const softcd::SceneBody& b = scene.bodies[body_b];
  return vertices ? a.vertex_triangle && b.vertex_triangle : a.edge_edge && b.edge_edge;
}

/// Returns pairs of vertices of triangles and triangles without them, whose boxes, grown by `reach` times the margins,
/// overlap.
Candidates vertex_triangles(const SceneView& scene, double reach) {
  std::vector<bool> occurs(scene.vertex_count, false);
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    for (const std::uint32_t v : scene.triangles[t].v) occurs[v] = true;
  }
  Candidates found;
  for (std::uint32_t v = 0; v < scene.vertex_count; ++v) {
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
      const auto [a, b, c] = scene.triangles[t].v;
      const std::uint32_t body_v = scene.vertex_body[v];
      const std::uint32_t body_t = scene.triangle_body[t];
      if (!occurs[v] || v == a || v == b || v == c || !wants(scene, body_v, body_t, true)) continue;
      if (!scene.bodies_may_touch(body_v, body_t)) continue;
      if (overlap(box_of_vertices(scene, {v}, reach * margin_of(scene, v)),
                  box_of_vertices(scene, {a, b, c}, reach * margin_of(scene, a)))) {
        found.push_back((static_cast<std::uint64_t>(v) << 32) | t);
      }
    }
  }
  return found;
}

Candidates edge_edges(const SceneView& scene, double reach) {
  Candidates found;
  for (std::uint32_t e = 0; e < scene.edge_count; ++e) {
    for (std::uint32_t g = e + 1; g < scene.edge_count; ++g) {
      const auto [a, b] = scene.edges[e].v;
      const auto [c, d] = scene.edges[g].v;
      if (a == c || a == d || b == c || b == d) continue;
      if (!wants(scene, scene.vertex_body[a], scene.vertex_body[c], false)) continue;
      if (!scene.bodies_may_touch(scene.vertex_body[a], scene.vertex_body[c])) continue;
      if (overlap(box_of_vertices(scene, {a, b}, reach * margin_of(scene, a)),
                  box_of_vertices(scene, {c, d}, reach * margin_of(scene, c)))) {
        found.push_back((static_cast<std::uint64_t>(e) << 32) | g);
      }
    }
  }
  return found;
}

/// Returns the pairs of `candidates` that are within their margins at t1, with a little to spare.
template <class Distance>
Candidates near_ones(const Candidates& candidates, const Distance& distance) {
  Candidates nearby;
  for (const std::uint64_t candidate : candidates) {
    const auto [length, margin] =
        distance(static_cast<std::uint32_t>(candidate >> 32), static_cast<std::uint32_t>(candidate));
    if (length < 0.9999 * margin) nearby.push_back(candidate);
  }
  return nearby;
}

/// Return functions that give a pair's distance at t1 and its margin.
auto distance_of_vertex_triangle(const SceneView& scene) {
  return [&scene](std::uint32_t v, std::uint32_t t) {
    const auto x = [&](std::uint32_t i) { return vec3_cast<double>(scene.x_t1[i]); };
    const auto [a, b, c] = scene.triangles[t].v;
    return std::pair(static_cast<double>(distance_vertex_triangle(x(v), x(a), x(b), x(c))),
                     margin_of(scene, v) + margin_of(scene, a));
  };
}
auto distance_of_edge_edge(const SceneView& scene) {
  return [&scene](std::uint32_t e, std::uint32_t g) {
    const auto x = [&](std::uint32_t i) { return vec3_cast<double>(scene.x_t1[i]); };
    const auto [a, b] = scene.edges[e].v;
    const auto [c, d] = scene.edges[g].v;
    return std::pair(static_cast<double>(distance_edge_edge(x(a), x(b), x(c), x(d))),
                     margin_of(scene, a) + margin_of(scene, c));
  };
}

Candidates near_vertex_triangles(const SceneView& scene) {
  return near_ones(vertex_triangles(scene, 1.001), distance_of_vertex_triangle(scene));
}
Candidates near_edge_edges(const SceneView& scene) {
  return near_ones(edge_edges(scene, 1.001), distance_of_edge_edge(scene));
}

std::array<Vec3d, 8> motion_of(const SceneView& scene, const std::array<std::uint32_t, 4>& vertices) {
  std::array<Vec3d, 8> rows{};
  for (std::size_t i = 0; i < 4; ++i) {
    rows[i] = vec3_cast<double>(scene.x_t0[vertices[i]]);
    rows[4 + i] = vec3_cast<double>(scene.x_t1[vertices[i]]);
  }
  return rows;
}

/// Return whether a pair touches during the step, exactly.
bool collide_vertex_triangle(const SceneView& scene, std::uint64_t pair) {
  const auto [a, b, c] = scene.triangles[static_cast<std::uint32_t>(pair)].v;
  return collides_vertex_triangle(motion_of(scene, {static_cast<std::uint32_t>(pair >> 32), a, b, c}));
}
bool collide_edge_edge(const SceneView& scene, std::uint64_t pair) {
  const auto [a, b] = scene.edges[static_cast<std::uint32_t>(pair >> 32)].v;
  const auto [c, d] = scene.edges[static_cast<std::uint32_t>(pair)].v;
  return collides_edge_edge(motion_of(scene, {a, b, c, d}));
}

Candidates colliding_vertex_triangles(const SceneView& scene) {
  Candidates colliding = vertex_triangles(scene, 0.0);
  std::erase_if(colliding, [&](std::uint64_t pair) { return !collide_vertex_triangle(scene, pair); });
  EXPECT_GT(colliding.size(), 100U);
  return colliding;
}
Candidates colliding_edge_edges(const SceneView& scene) {
  Candidates colliding = edge_edges(scene, 0.0);
  std::erase_if(colliding, [&](std::uint64_t pair) { return !collide_edge_edge(scene, pair); });
  EXPECT_GT(colliding.size(), 100U);
  return colliding;
}

TEST(Bits, counted_and_found) {
  for (std::uint32_t bits = 0; bits < 64; ++bits) {
    std::uint32_t count = 0;
    for (int bit = 0; bit < 3; ++bit) {
      if (((bits >> bit) & 1U) == 0) continue;
      EXPECT_EQ(nth_bit3(bits, count), bit);
      ++count;
    }
    EXPECT_EQ(count_bits3(bits), count);
  }
}

class FeaturePairs : public testing::TestWithParam<bool> {
 public:
  static HostScene make_scene(bool continuous) {
    std::vector<HostBody> bodies{{tangle(1), {}, 0.01F},
                                 {tangle(2), {}, 0.05F, false},
                                 {tangle(3), {}, 0.0F, true, false, true},
                                 {tangle(4), {}, 0.02F, true, true, false}};
    for (HostBody& body : bodies) {
      body.x_t0 = jittered(body.mesh.positions, 0.2, 9);
      snap_to_grid(body.x_t0, 17);
    }
    return HostScene(std::move(bodies), continuous);
  }
};

template <ContactKind kKind, bool kContinuous>
Candidates expanded_as(const SceneView& scene, const HostVolumes& bounds, const std::vector<std::uint64_t>& pairs) {
  Collector<std::uint64_t> found;
  const ExpandPair<kKind, kContinuous> stage{{scene}, bounds.shapes.data(), bounds.volumes.data(), pairs.data()};
  typename ExpandPair<kKind, kContinuous>::Candidate candidate;
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    const FeatureWork<kKind> work = stage.load_item(i);
    for (std::uint32_t part = 0; part < work.part_count(); ++part) {
      if (stage.filter(work, part, candidate)) stage.test(candidate, found);
    }
  }
  return found.items;
}

/// The parts of a scene in stars that are spread out.
struct Spread {
  std::vector<std::uint8_t> vertices, triangles, edges;
  SpreadParts parts;

  Spread(const SceneView& scene, const std::vector<VertexStar>& stars)
      : vertices(scene.vertex_count, 2),
        triangles(scene.triangle_count, 2),
        edges(scene.edge_count, 2),
        parts{vertices.data(), triangles.data(), edges.data()} {
    const TestStar test_star{scene, stars.data(), parts};
    for (std::uint32_t i = 0; i < stars.size(); ++i) test_star(i);
    const FindSpreadParts find_spread_parts{scene, parts};
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) find_spread_parts(t);
  }
};

template <ContactKind kKind, bool kContinuous>
Candidates neighbours_that_stay(const SceneView& scene, const std::vector<std::uint64_t>& neighbours,
                                const std::vector<VertexStar>& stars) {
  Collector<std::uint64_t> found;
  const Spread spread(scene, stars);
  const TestNeighbours<kKind, kContinuous> stage{{scene}, neighbours.data(), spread.parts};
  FeatureCandidate candidate;
  for (std::uint32_t i = 0; i < neighbours.size(); ++i) {
    if (stage.filter(stage.load_item(i), 0, candidate)) stage.test(candidate, found);
  }
  return found.items;
}

template <ContactKind kKind>
Candidates expanded(const SceneView& scene, const HostVolumes& bounds, const std::vector<std::uint64_t>& pairs) {
  return scene.is_swept ? expanded_as<kKind, true>(scene, bounds, pairs)
                        : expanded_as<kKind, false>(scene, bounds, pairs);
}

std::vector<std::uint64_t> overlapping_pairs(const SceneView& scene, const HostVolumes& bounds) {
  std::vector<std::uint64_t> pairs;
  for (std::uint32_t a = 0; a < scene.triangle_count; ++a) {
    for (std::uint32_t b = a + 1; b < scene.triangle_count; ++b) {
      if (!scene.bodies_may_touch(scene.triangle_body[a], scene.triangle_body[b])) continue;
      if (overlap(bounds.volumes[a], bounds.volumes[b])) pairs.push_back(pair_key(a, b));
    }
  }
  return pairs;
}

// All pairs of triangles whose volumes overlap go in. Each candidate comes out once and none is missing. All of them
// have overlapping boxes.
TEST_P(FeaturePairs, each_candidate_once) {
  const HostScene host = make_scene(GetParam());
  const SceneView scene = host.view();
  const HostVolumes bounds(scene);
  const std::vector<std::uint64_t> pairs = overlapping_pairs(scene, bounds);
  Candidates vt = expanded<ContactKind::vertex_triangle>(scene, bounds, pairs);
  Candidates ee = expanded<ContactKind::edge_edge>(scene, bounds, pairs);
  for (Candidates* candidates : {&vt, &ee}) {
    std::sort(candidates->begin(), candidates->end());
    EXPECT_EQ(std::adjacent_find(candidates->begin(), candidates->end()), candidates->end());
    EXPECT_GT(candidates->size(), 100U);
  }
  // The stages round outward, so slightly more than exact overlaps may come out, but nothing less. Volumes of triangles
  // other than boxes may reject more, but never features within the margins of each other.
  const auto contains_all = [](const Candidates& all, const Candidates& part) {
    return std::includes(all.begin(), all.end(), part.begin(), part.end());
  };
  EXPECT_TRUE(contains_all(vertex_triangles(scene, 1.001), vt));
  EXPECT_TRUE(contains_all(edge_edges(scene, 1.001), ee));
  EXPECT_TRUE(contains_all(vt, near_vertex_triangles(scene)));
  EXPECT_TRUE(contains_all(ee, near_edge_edges(scene)));
  if (GetParam()) {
    EXPECT_TRUE(contains_all(vt, colliding_vertex_triangles(scene)));
    EXPECT_TRUE(contains_all(ee, colliding_edge_edges(scene)));
  } else {
    EXPECT_LE(vt.size(), near_vertex_triangles(scene).size() * 6 / 5) << "few are further apart";
    EXPECT_LE(ee.size(), near_edge_edges(scene).size() * 6 / 5) << "few are further apart";
  }
}

// By ContactRule::slab volumes reach farther than contacts of edges do. Edges of pairs that only this reach brings
// together are not listed, and no contact of edges is lost.
TEST(ReachOfEdges, is_that_of_their_margins) {
  const HostScene host = FeaturePairs::make_scene(false);
  const SceneView by_distance = host.view();
  const HostVolumes distance_bounds(by_distance);
  Candidates expected =
      expanded<ContactKind::edge_edge>(by_distance, distance_bounds, overlapping_pairs(by_distance, distance_bounds));

  SceneView scene = host.view();
  scene.contact_rule = ContactRule::slab;
  const HostVolumes bounds(scene);
  const std::vector<std::uint64_t> pairs = overlapping_pairs(scene, bounds);
  Candidates found = expanded<ContactKind::edge_edge>(scene, bounds, pairs);
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  // Volumes of the wider reach may let further pairs through.
  EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));

  const ExpandPair<ContactKind::edge_edge, false> stage{
      {scene}, bounds.shapes.data(), bounds.volumes.data(), pairs.data()};
  const auto grown_box = [&](std::uint32_t t) {
    const auto [a, b, c] = scene.triangles[t].v;
    return box_of_vertices(scene, {a, b, c}, 1.001 * margin_of(scene, a));
  };
  std::size_t listed = 0;
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    const FeatureWork<ContactKind::edge_edge> work = stage.load_item(i);
    if (work.part_count() == 0) continue;
    ++listed;
    EXPECT_TRUE(overlap(grown_box(work.a), grown_box(work.b)));
  }
  EXPECT_GT(listed, 100U);
}

// ContactRule::slab reaches one margin along the normal, and farther only beside the triangle.
TEST(ReachOfSlabs, is_one_margin_along_the_normal) {
  constexpr float kMargin = 0.125F;
  for (const float height : {0.99F * kMargin, 1.01F * kMargin}) {
    const Vec3f x[] = {{0.5F, 0.5F, height}, {0.0F, 0.0F, 0.0F}, {2.0F, 0.0F, 0.0F}, {0.0F, 2.0F, 0.0F}};
    // Turned, so that no axis tells the height.
    std::vector<Vec3f> turned;
    for (const Vec3f& v : x) turned.push_back({0.6F * v.x + 0.8F * v.z, v.y, 0.6F * v.z - 0.8F * v.x});
    FeatureTest<ContactKind::vertex_triangle, false> test{};
    test.scene.x_t1 = turned.data();
    test.scene.contact_rule = ContactRule::slab;
    const FeatureCandidate candidate = {{{0, 1, 2, 3}}, 0, 0, test.reach_of(kMargin, 0.0F)};
    EXPECT_TRUE(test.filter(candidate)) << height;
    EXPECT_EQ(test.keeps(candidate), height < kMargin) << height;
  }
}

template <ContactKind kKind>
void expect_neighbours_to_stand_for_their_pairs(const SceneView& scene, const HostVolumes& bounds,
                                                const std::vector<std::uint64_t>& neighbours,
                                                const std::vector<VertexStar>& stars) {
  std::vector<std::uint64_t> pairs = overlapping_pairs(scene, bounds);
  Candidates expected = expanded<kKind>(scene, bounds, pairs);
  std::erase_if(pairs, [&](std::uint64_t pair) {
    const auto a = static_cast<std::uint32_t>(pair >> 32);
    const auto b = static_cast<std::uint32_t>(pair);
    return scene.bodies[scene.triangle_body[a]].lists_neighbours &&
           share_vertex(scene.triangles[a], scene.triangles[b]);
  });
  Candidates found = expanded<kKind>(scene, bounds, pairs);
  const Candidates listed = scene.is_swept ? neighbours_that_stay<kKind, true>(scene, neighbours, stars)
                                           : neighbours_that_stay<kKind, false>(scene, neighbours, stars);
  EXPECT_GT(listed.size(), 5U);
  found.insert(found.end(), listed.begin(), listed.end());
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, expected);
}

TEST_P(FeaturePairs, listed_neighbours_stand_for_their_pairs) {
  HostScene host = make_scene(GetParam());
  const SceneView scene = host.view();
  for (std::uint32_t b = 0; b < scene.body_count; ++b) host.body(b).lists_neighbours = scene.bodies_may_touch(b, b);
  const HostVolumes bounds(scene);
  const Topology topology = build_topology({scene.triangles, scene.triangle_count}, scene.vertex_count);
  const NeighbourFeatures neighbours = neighbour_features(view_of(topology), topology.ownership);
  expect_neighbours_to_stand_for_their_pairs<ContactKind::vertex_triangle>(scene, bounds, neighbours.vertex_triangle,
                                                                           neighbours.stars);
  expect_neighbours_to_stand_for_their_pairs<ContactKind::edge_edge>(scene, bounds, neighbours.edge_edge,
                                                                     neighbours.stars);
}

// Most neighbours of a cloth in folds lie in stars that are spread out. None of these is within the margins or
// collides.
TEST_P(FeaturePairs, neighbours_in_spread_stars_are_apart) {
  HostBody cloth{crumpled_cloth(24, 20, 0.1, 0.02, 5), {}, 0.01F};
  cloth.mesh.positions = jittered(cloth.mesh.positions, 0.015, 3);
  cloth.x_t0 = jittered(cloth.mesh.positions, 0.02, 4);
  snap_to_grid(cloth.mesh.positions, 17);
  snap_to_grid(cloth.x_t0, 17);
  HostScene host({cloth}, GetParam());
  host.body(0).lists_neighbours = host.body(0).has_stars = true;
  const SceneView scene = host.view();
  const Topology topology = build_topology(cloth.mesh.triangles, scene.vertex_count);
  const NeighbourFeatures neighbours = neighbour_features(view_of(topology), topology.ownership);
  const Spread spread(scene, neighbours.stars);
  Candidates vt = neighbours.vertex_triangle;
  Candidates ee = neighbours.edge_edge;
  const std::size_t all = vt.size() + ee.size();
  std::erase_if(vt, [&](std::uint64_t pair) { return !are_spread<ContactKind::vertex_triangle>(spread.parts, pair); });
  std::erase_if(ee, [&](std::uint64_t pair) { return !are_spread<ContactKind::edge_edge>(spread.parts, pair); });
  EXPECT_GT(vt.size() + ee.size(), all / 2);
  EXPECT_LT(vt.size() + ee.size(), all);
  EXPECT_TRUE(near_ones(vt, distance_of_vertex_triangle(scene)).empty());
  EXPECT_TRUE(near_ones(ee, distance_of_edge_edge(scene)).empty());
  if (!GetParam()) return;
  for (const std::uint64_t pair : vt) EXPECT_FALSE(collide_vertex_triangle(scene, pair));
  for (const std::uint64_t pair : ee) EXPECT_FALSE(collide_edge_edge(scene, pair));
}

INSTANTIATE_TEST_SUITE_P(Kinds, FeaturePairs, testing::Bool(),
                         [](const auto& test) { return test.param ? "swept" : "still"; });

}  // namespace
}  // namespace softcd::test
