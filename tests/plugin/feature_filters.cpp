// Contacts that are excluded by lists of pairs of bodies, by vertices' groups and masks, on the mesh and at rest.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "reference_distance.hpp"

namespace softcd::test {
namespace {

/// The filters of a scene; bodies are numbered by their places.
struct Filters {
  std::vector<std::vector<VertexFilter>> vertices;
  std::vector<Positions3> x_rest;
  std::vector<BodyPair> ignored;
};

/// The number of edges between each two vertices of a mesh.
class MeshDistances {
 public:
  explicit MeshDistances(const SceneBody& body) : steps_(body.x_t1.size()) {
    std::vector<std::set<std::uint32_t>> around(body.x_t1.size());
    for (const Edge& edge : edges_of(body.triangles)) {
      around[edge.v[0]].insert(edge.v[1]);
      around[edge.v[1]].insert(edge.v[0]);
    }
    for (std::uint32_t from = 0; from < steps_.size(); ++from) {
      std::vector<std::uint32_t>& steps = steps_[from];
      steps.assign(steps_.size(), 1000);
      steps[from] = 0;
      std::vector<std::uint32_t> queue{from};
      for (std::size_t i = 0; i < queue.size(); ++i) {
        for (const std::uint32_t next : around[queue[i]]) {
          if (steps[next] < 1000) continue;
          steps[next] = steps[queue[i]] + 1;
          queue.push_back(next);
        }
      }
    }
  }

  std::uint32_t operator()(std::uint32_t v, std::uint32_t w) const { return steps_[v][w]; }

 private:
  std::vector<std::vector<std::uint32_t>> steps_;
};

/// Decides which contacts the filters must exclude. Shares no code with the detector.
class Oracle {
 public:
  Oracle(const Scene& scene, const Filters& filters) : scene_(scene), filters_(filters) {
    for (const SceneBody& body : scene) {
      const bool is_needed = body.settings.self_collision && body.settings.neighbour_rings > 1;
      distances_.push_back(is_needed ? std::optional<MeshDistances>(body) : std::nullopt);
    }
  }

  bool excludes(const Contact& contact) const {
    return is_ignored(contact) || is_masked(contact) || is_near_on_mesh(contact) || is_near_at_rest(contact);
  }
  bool is_ignored(const Contact& contact) const {
    return std::any_of(filters_.ignored.begin(), filters_.ignored.end(), [&](const BodyPair& pair) {
      return std::minmax(pair.a, pair.b) == std::minmax(contact.body_a, contact.body_b);
    });
  }
  bool is_masked(const Contact& contact) const {
    return !any_pair(contact, [&](std::uint32_t v, std::uint32_t w) {
      const VertexFilter a = filter_of(contact.body_a, v);
      const VertexFilter b = filter_of(contact.body_b, w);
      return (a.group & b.mask) != 0 && (b.group & a.mask) != 0;
    });
  }
  bool is_near_on_mesh(const Contact& contact) const {
    if (contact.body_a != contact.body_b || !distances_[contact.body_a.value]) return false;
    const std::uint32_t rings = scene_[contact.body_a.value].settings.neighbour_rings;
    return any_pair(
        contact, [&](std::uint32_t v, std::uint32_t w) { return (*distances_[contact.body_a.value])(v, w) < rings; });
  }
  bool is_near_at_rest(const Contact& contact) const {
    const SceneBody& body = scene_[contact.body_a.value];
    if (contact.body_a != contact.body_b || !(body.settings.rest_distance > 0.0F)) return false;
    const Positions3& x = filters_.x_rest[contact.body_a.value];
    const auto& v = contact.vertices;
    const bool is_vt = contact.kind == ContactKind::vertex_triangle;
    const long double distance = is_vt ? distance_vertex_triangle(x[v[0]], x[v[1]], x[v[2]], x[v[3]])
                                       : distance_edge_edge(x[v[0]], x[v[1]], x[v[2]], x[v[3]]);
    const long double limit = body.settings.rest_distance;
    EXPECT_GT(std::abs(distance - limit), 1e-9L) << "decides nothing";
    return distance <= limit;
  }

 private:
  VertexFilter filter_of(BodyId body, std::uint32_t v) const {
    if (filters_.vertices.empty() || filters_.vertices[body.value].empty()) return {};
    return filters_.vertices[body.value][v];
  }

  template <class Relation>
  static bool any_pair(const Contact& contact, const Relation& relation) {
    const int count_a = contact.kind == ContactKind::vertex_triangle ? 1 : 2;
    bool any = false;
    for (int a = 0; a < count_a; ++a) {
      for (int b = count_a; b < 4; ++b) any |= relation(contact.vertices[a], contact.vertices[b]);
    }
    return any;
  }

  const Scene& scene_;
  const Filters& filters_;
  std::vector<std::optional<MeshDistances>> distances_;
};

/// Returns the scene without its bodies' filters.
Scene without_filters(Scene scene) {
  for (SceneBody& body : scene) {
    body.settings.neighbour_rings = 1;
    body.settings.rest_distance = 0.0F;
  }
  return scene;
}

void set_filters(CollisionPipeline& pipeline, const Filters& filters) {
  for (std::uint32_t b = 0; b < filters.vertices.size(); ++b)
    pipeline.scene.set_vertex_filters({b}, filters.vertices[b]);
  for (std::uint32_t b = 0; b < filters.x_rest.size(); ++b) pipeline.scene.set_rest_positions({b}, filters.x_rest[b]);
  pipeline.scene.set_ignored_pairs(filters.ignored);
}

/// Expects the contacts to be those without filters that the oracle admits, in the same bytes. Returns the number of
/// excluded contacts.
std::size_t expect_filtered(LoadedScene& loaded, const Filters& filters) {
  const std::vector<Contact> all = detect_once(without_filters(loaded.scene), loaded.pipeline.options());
  const Oracle oracle(loaded.scene, filters);
  std::vector<Contact> expected;
  std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
               [&](const Contact& contact) { return !oracle.excludes(contact); });
  const Span<const Contact> found = loaded.pipeline.detect();
  EXPECT_FALSE(expected.empty());
  EXPECT_TRUE(identical(found, expected)) << found.size() << " found, " << expected.size() << " expected";
  return all.size() - expected.size();
}

std::size_t expect_filtered(const Scene& scene, const Filters& filters, Detection detection) {
  LoadedScene loaded = load(scene, test_options(detection));
  set_filters(loaded.pipeline, filters);
  return expect_filtered(loaded, filters);
}

Mesh rough_cloth(std::uint64_t seed) {
  Mesh mesh = crumpled_cloth(14, 10, 0.25, 0.5, seed);
  mesh.positions = jittered(mesh.positions, 0.2, seed + 1);
  snap_to_grid(mesh.positions, 17);
  return mesh;
}

SceneBody in_motion(const Mesh& mesh, std::uint64_t seed) {
  Positions3 x_t1 = jittered(mesh.positions, 0.3, seed);
  snap_to_grid(x_t1, 17);
  return moving(mesh, std::move(x_t1), everything(0.03F));
}

Mesh soup(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 120;
  options.half_extent = 1.5;
  options.size_ratio = 10.0;
  options.degenerate_share = 0.1;
  options.joined_share = 0.6;
  options.seed = seed;
  return triangle_soup(options);
}

/// Returns cloths and soups that penetrate each other.
Scene tangle() {
  Scene scene{in_motion(rough_cloth(7), 9), in_motion(moved(rough_cloth(17), {0.3, 0.2, 0.3}), 19)};
  scene.push_back(in_motion(moved(soup(3), {1.5, 1.0, 0.3}), 29));
  scene.push_back(in_motion(moved(soup(4), {1.5, 1.0, 0.3}), 39));
  return scene;
}

/// Vertices in stripes that touch some others.
std::vector<VertexFilter> stripes(std::size_t count, std::uint32_t shift) {
  std::vector<VertexFilter> filters(count);
  for (std::size_t v = 0; v < count; ++v) {
    const auto stripe = static_cast<std::uint32_t>(v / 11 + shift) % 3;
    filters[v] = {1U << stripe, stripe == 0 ? 5U : (stripe == 1 ? 4U : 3U)};
  }
  return filters;
}

Filters stripes_of(const Scene& scene) {
  Filters filters;
  for (std::uint32_t b = 0; b < scene.size(); ++b) filters.vertices.push_back(stripes(scene[b].x_t1.size(), b));
  return filters;
}

/// Returns rest positions: the sheets flat, the soups unchanged.
std::vector<Positions3> at_rest(const Scene& scene) {
  std::vector<Positions3> x_rest;
  for (const SceneBody& body : scene) x_rest.push_back(body.x_t0);
  for (const std::size_t cloth : {0U, 1U}) x_rest[cloth] = grid_cloth(14, 10, 0.25).positions;
  return x_rest;
}

class FeatureFilter : public testing::TestWithParam<Detection> {};
INSTANTIATE_TEST_SUITE_P(Detections, FeatureFilter, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& detection) { return detection.param == Detection::dcd ? "dcd" : "ccd"; });

TEST_P(FeatureFilter, what_is_found_without_them_is_right) {
  Scene scene = tangle();
  if (GetParam() == Detection::ccd) {
    for (SceneBody& body : scene) body.settings.margin = 0.0F;
    expect_continuous_contacts(scene, test_options(Detection::ccd));
  } else {
    expect_discrete_contacts(scene, test_options(Detection::dcd));
  }
}

TEST_P(FeatureFilter, of_vertices) {
  const Scene scene = tangle();
  Filters filters = stripes_of(scene);
  EXPECT_GT(expect_filtered(scene, filters, GetParam()), 200U);
  filters.vertices[1].clear();
  EXPECT_GT(expect_filtered(scene, filters, GetParam()), 100U);
}

TEST_P(FeatureFilter, a_triangle_is_kept_from_what_all_its_vertices_are) {
  Scene scene{still(grid_cloth(2, 2, 1.0), everything(0.1F)),
              still(moved(scaled(grid_cloth(2, 2, 1.0), 0.1), {0.6, 0.3, 0.05}), everything(0.1F))};
  for (SceneBody& body : scene) {
    body.settings.self_collision = false;
    body.settings.features = {true, false};
  }
  Filters filters{{{{1, 2}, {1, 2}, {1, 2}, {1, 2}}, {{1, 1}, {1, 1}, {1, 1}, {1, 1}}}, {}, {}};
  LoadedScene loaded = load(scene, test_options(GetParam()));
  set_filters(loaded.pipeline, filters);
  EXPECT_TRUE(loaded.pipeline.detect().empty());
  for (VertexFilter& filter : filters.vertices[1]) filter.group = 2;
  set_filters(loaded.pipeline, filters);
  EXPECT_EQ(expect_filtered(loaded, filters), 0U);
  // Only one vertex of the first triangle, and none of the other's, may touch.
  filters.vertices[0] = {{0, 0}, {2, 2}, {0, 0}, {0, 0}};
  filters.vertices[1] = {{2, 2}, {2, 2}, {2, 2}, {2, 2}};
  set_filters(loaded.pipeline, filters);
  EXPECT_GT(expect_filtered(loaded, filters), 0U);
}

TEST_P(FeatureFilter, rings_of_neighbours) {
  for (const std::uint32_t rings : {2U, 3U, 4U, 7U}) {
    SCOPED_TRACE(rings);
    Scene scene = tangle();
    for (SceneBody& body : scene) body.settings.neighbour_rings = rings;
    scene[1].settings.neighbour_rings = 1;
    EXPECT_GT(expect_filtered(scene, {}, GetParam()), 100U);
  }
}

TEST_P(FeatureFilter, near_at_rest) {
  for (const float distance : {0.0501F, 0.26F, 0.601F}) {
    SCOPED_TRACE(distance);
    Scene scene = tangle();
    for (SceneBody& body : scene) body.settings.rest_distance = distance;
    scene[3].settings.rest_distance = 0.0F;
    EXPECT_GT(expect_filtered(scene, {{}, at_rest(scene), {}}, GetParam()), 20U);
  }
}

TEST_P(FeatureFilter, rest_positions_may_be_far_away) {
  Scene scene = tangle();
  for (SceneBody& body : scene) body.settings.rest_distance = 0.26F;
  Filters filters{{}, at_rest(scene), {}};
  for (Positions3& x : filters.x_rest) x = translated(x, {1e6, -2e5, 1e7});
  EXPECT_GT(expect_filtered(scene, filters, GetParam()), 100U);
}

TEST_P(FeatureFilter, ignored_pairs) {
  const Scene scene = tangle();
  EXPECT_GT(expect_filtered(scene, {{}, {}, {{BodyId{3}, BodyId{2}}, {BodyId{0}, BodyId{0}}}}, GetParam()), 200U);
}

/// Returns a scene with all filters together.
Scene with_everything(Filters& filters) {
  Scene scene = tangle();
  filters = stripes_of(scene);
  filters.vertices[2].clear();
  filters.x_rest = at_rest(scene);
  filters.ignored = {{BodyId{0}, BodyId{3}}};
  for (std::uint32_t b = 0; b < scene.size(); ++b) {
    scene[b].settings.neighbour_rings = 1 + b;
    scene[b].settings.rest_distance = b == 1 ? 0.0F : 0.12F;
  }
  return scene;
}

TEST_P(FeatureFilter, together_and_changed_between_detections) {
  Filters filters;
  LoadedScene loaded = load(with_everything(filters), test_options(GetParam()));
  set_filters(loaded.pipeline, filters);
  EXPECT_GT(expect_filtered(loaded, filters), 200U);
  filters.vertices[0] = stripes(loaded.scene[0].x_t1.size(), 2);
  filters.ignored = {{BodyId{1}, BodyId{0}}, {BodyId{2}, BodyId{2}}};
  set_filters(loaded.pipeline, filters);
  EXPECT_GT(expect_filtered(loaded, filters), 200U);
  for (std::uint32_t b = 0; b < loaded.scene.size(); ++b) {
    loaded.scene[b].settings.neighbour_rings = 4 - b;
    loaded.scene[b].settings.rest_distance = b == 1 ? 0.3F : 0.0F;
    loaded.pipeline.scene.set_settings(loaded.ids[b], loaded.scene[b].settings);
  }
  EXPECT_GT(expect_filtered(loaded, filters), 200U);
  filters = {{{}, {}, {}, {}}, {}, {}};
  set_filters(loaded.pipeline, filters);
  for (std::uint32_t b = 0; b < loaded.scene.size(); ++b) {
    loaded.scene[b].settings.neighbour_rings = 1;
    loaded.scene[b].settings.rest_distance = 0.0F;
    loaded.pipeline.scene.set_settings(loaded.ids[b], loaded.scene[b].settings);
  }
  EXPECT_EQ(expect_filtered(loaded, filters), 0U);
}

TEST_P(FeatureFilter, stay_with_their_bodies_when_others_come_and_go) {
  Filters filters;
  const Scene scene = with_everything(filters);
  const SceneBody stranger = still(moved(soup(8), {30, 0, 0}), everything());
  CollisionPipeline pipeline(test_options(GetParam()));
  const auto add = [&](const SceneBody& body) {
    const BodyId id =
        pipeline.scene.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings});
    pipeline.scene.set_positions(id, body.x_t0, body.x_t1);
    return id;
  };
  const BodyId first = add(stranger);
  std::vector<BodyPair> ignored;
  for (std::uint32_t b = 0; b < scene.size(); ++b) {
    const BodyId id = add(scene[b]);
    pipeline.scene.set_vertex_filters(id, filters.vertices[b]);
    pipeline.scene.set_rest_positions(id, filters.x_rest[b]);
  }
  for (const BodyPair& pair : filters.ignored) ignored.push_back({{pair.a.value + 1}, {pair.b.value + 1}});
  pipeline.scene.set_ignored_pairs(ignored);
  const auto found = [&] {
    std::vector<FeaturePair> pairs = features_of(pipeline.detect());
    std::erase_if(pairs, [](const FeaturePair& pair) { return pair.body_a == 0 || pair.body_a > 4; });
    for (FeaturePair& pair : pairs) --pair.body_a, --pair.body_b;
    return pairs;
  };
  LoadedScene loaded = load(scene, test_options(GetParam()));
  set_filters(loaded.pipeline, filters);
  const std::vector<FeaturePair> expected = features_of(loaded.pipeline.detect());
  EXPECT_EQ(found(), expected);
  pipeline.scene.remove_body(first);
  EXPECT_EQ(found(), expected);
  const BodyId last = add(stranger);
  EXPECT_EQ(found(), expected);
  pipeline.scene.update_body(last, {scene[0].triangles, static_cast<std::uint32_t>(scene[0].x_t1.size()), {}});
  EXPECT_EQ(found(), expected);
}

TEST_P(FeatureFilter, are_gone_when_the_body_is_updated) {
  Scene scene{in_motion(rough_cloth(7), 9)};
  LoadedScene loaded = load(scene, test_options(GetParam()));
  Filters filters = stripes_of(scene);
  set_filters(loaded.pipeline, filters);
  EXPECT_GT(expect_filtered(loaded, filters), 20U);
  const auto count = static_cast<std::uint32_t>(scene[0].x_t1.size());
  loaded.pipeline.scene.update_body(loaded.ids[0], {scene[0].triangles, count, scene[0].settings});
  loaded.pipeline.scene.set_positions(loaded.ids[0], loaded.scene[0].x_t0, loaded.scene[0].x_t1);
  EXPECT_EQ(expect_filtered(loaded, {}), 0U);
}

TEST_P(FeatureFilter, count_in_reused_pairs) {
  Filters filters;
  LoadedScene loaded = load(with_everything(filters), test_options(GetParam()));
  bool has_reused = false;
  for (std::uint32_t step = 0; step < 8; ++step) {
    if (step == 5) filters.vertices[1] = stripes(loaded.scene[1].x_t1.size(), 7);
    set_filters(loaded.pipeline, filters);
    expect_filtered(loaded, filters);
    has_reused |= loaded.pipeline.query.statistics().reused_pairs;
    for (std::size_t b = 0; b < loaded.scene.size(); ++b) {
      loaded.pipeline.scene.set_positions(loaded.ids[b], loaded.scene[b].x_t0, loaded.scene[b].x_t1);
    }
  }
  EXPECT_TRUE(has_reused);
}

TEST_P(FeatureFilter, only_pairs_that_are_listed) {
  const test::Scene scene = tangle();
  softcd::Scene bodies(SceneOptions{backend_under_test()});
  for (const SceneBody& body : scene) {
    const BodyId id = bodies.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings});
    bodies.set_positions(id, body.x_t0, body.x_t1);
  }
  Query all(bodies, test_options(GetParam()));
  Query some(bodies, test_options(GetParam()));
  const auto expect = [&](const std::vector<BodyPair>& only) {
    some.set_only_pairs(only);
    const Span<const Contact> found = all.detect();
    std::vector<Contact> expected(found.begin(), found.end());
    std::erase_if(expected, [&](const Contact& contact) {
      return !only.empty() && std::none_of(only.begin(), only.end(), [&](const BodyPair& pair) {
        return std::minmax(pair.a, pair.b) == std::minmax(contact.body_a, contact.body_b);
      });
    });
    EXPECT_TRUE(identical(some.detect(), expected));
    return expected.size();
  };
  const std::size_t count = expect({});
  EXPECT_GT(expect({{BodyId{1}, BodyId{0}}, {BodyId{2}, BodyId{2}}, {BodyId{99}, BodyId{0}}}), 10U);
  bodies.set_ignored_pairs(std::vector<BodyPair>{{BodyId{0}, BodyId{1}}});
  EXPECT_GT(expect({{BodyId{1}, BodyId{0}}, {BodyId{2}, BodyId{2}}}), 10U);
  EXPECT_LT(expect({}), count);
}

TEST(Filtering, pairs_that_are_not_ignored_any_more_have_changed) {
  const test::Scene scene = tangle();
  softcd::Scene bodies(SceneOptions{backend_under_test()});
  for (const SceneBody& body : scene) {
    const BodyId id = bodies.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings});
    bodies.set_positions(id, body.x_t0, body.x_t1);
  }
  bodies.set_ignored_pairs(std::vector<BodyPair>{{BodyId{0}, BodyId{1}}});
  Query query(bodies, test_options(Detection::dcd));
  query.detect();
  EXPECT_TRUE(query.detect(Pairs::changed).empty());
  bodies.set_ignored_pairs({});
  const Span<const Contact> found = query.detect(Pairs::changed);
  EXPECT_TRUE(std::any_of(found.begin(), found.end(),
                          [](const Contact& c) { return c.body_a.value == 0 && c.body_b.value == 1; }));
}

TEST(Filtering, of_neighbours_are_not_asked_where_a_query_says_so) {
  Filters filters;
  const test::Scene scene = with_everything(filters);
  filters.vertices.clear();
  filters.ignored.clear();
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  set_filters(loaded.pipeline, filters);
  PipelineOptions options = test_options(Detection::dcd);
  options.neighbour_filters = false;
  const std::vector<Contact> all = detect_once(without_filters(scene), options);
  EXPECT_LT(loaded.pipeline.detect().size(), all.size());
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(loaded.pipeline.detect(), all));
}

TEST(Filtering, with_memory_in_parts_and_a_limit) {
  Filters filters;
  LoadedScene loaded = load(with_everything(filters), test_options(Detection::dcd));
  set_filters(loaded.pipeline, filters);
  const Span<const Contact> found = loaded.pipeline.detect();
  const std::vector<Contact> expected(found.begin(), found.end());
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = loaded.pipeline.query.statistics().peak_bytes * 3 / 4;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(loaded.pipeline.detect(), expected));
  EXPECT_GT(loaded.pipeline.query.statistics().chunks, 1U);
}

TEST(Filtering, takes_vertices_without_filters_for_group_1) {
  const Mesh mesh = grid_cloth(2, 2, 1.0);
  CollisionPipeline pipeline(test_options(Detection::dcd));
  const BodyId filtered = pipeline.scene.add_body({mesh.triangles, 4, everything(0.1F)});
  const BodyId plain = pipeline.scene.add_body({mesh.triangles, 4, everything(0.1F)});
  for (const BodyId body : {filtered, plain}) pipeline.scene.set_positions(body, mesh.positions);
  EXPECT_FALSE(pipeline.detect().empty());
  pipeline.scene.set_vertex_filters(filtered, std::vector<VertexFilter>(4, {2, 2}));
  EXPECT_TRUE(pipeline.detect().empty());
  pipeline.scene.set_vertex_filters(filtered, std::vector<VertexFilter>(4, {2, 1}));
  EXPECT_FALSE(pipeline.detect().empty());
}

TEST(Filtering, errors) {
  CollisionPipeline pipeline(test_options(Detection::dcd));
  const Mesh mesh = grid_cloth(3, 3, 1.0);
  const BodyId body = pipeline.scene.add_body({mesh.triangles, 9, everything()});
  pipeline.scene.set_positions(body, mesh.positions);
  EXPECT_EQ(error_of([&] { pipeline.scene.set_vertex_filters(body, std::vector<VertexFilter>(8)); }),
            "body 0: 8 vertex filters were given, but the body has 9 vertices.");
  EXPECT_EQ(error_of([&] {
              pipeline.scene.set_ignored_pairs(std::vector<BodyPair>{{body, BodyId{4}}});
            }),
            "body 4 is not in the scene; it was removed, or never added.");
  Positions3 x_rest = mesh.positions;
  x_rest[5].z = NAN;
  EXPECT_EQ(error_of([&] { pipeline.scene.set_rest_positions(body, x_rest); }),
            "body 0: vertex 5 of its rest positions is not finite, or beyond 1e37.");
  x_rest.pop_back();
  EXPECT_EQ(error_of([&] { pipeline.scene.set_rest_positions(body, x_rest); }),
            "body 0: 8 positions were given for rest, but the body has 9 vertices.");
  BodySettings settings = everything();
  settings.neighbour_rings = 0;
  EXPECT_EQ(error_of([&] { pipeline.scene.set_settings(body, settings); }),
            "body 0: its neighbour_rings is 0, but must be 1 to 16.");
  settings.neighbour_rings = 1;
  settings.rest_distance = -1.0F;
  EXPECT_EQ(error_of([&] { pipeline.scene.set_settings(body, settings); }),
            "body 0: its rest_distance is -1, but must be finite and at least 0.");
  settings.rest_distance = 0.5F;
  pipeline.scene.set_settings(body, settings);
  EXPECT_EQ(error_of([&] { pipeline.detect(); }),
            "body 0: its rest_distance is 0.5, but it has no rest positions; use set_rest_positions().");
  pipeline.scene.set_rest_positions(body, mesh.positions);
  EXPECT_TRUE(pipeline.detect().empty());
}

// A fan's hub is near all of its rim.
TEST(Filtering, rings_around_a_vertex_of_many_triangles) {
  Mesh fan;
  fan.positions.push_back({0, 0, 0});
  constexpr std::uint32_t kCount = 300;
  for (std::uint32_t i = 0; i <= kCount; ++i) {
    const double angle = 0.05 * i;
    fan.positions.push_back({std::cos(angle), std::sin(angle), 0.0005 * i});
    if (i > 0) fan.triangles.push_back({{0, i, i + 1}});
  }
  snap_to_grid(fan.positions, 20);
  test::Scene scene{still(fan, everything(0.05F)), still(moved(fan, {0.1, 0.1, 0.01}), everything(0.02F))};
  scene[0].settings.neighbour_rings = 2;
  EXPECT_GT(expect_filtered(scene, {}, Detection::dcd), 100U);
  scene[0].settings.neighbour_rings = 3;
  EXPECT_GT(expect_filtered(scene, {}, Detection::dcd), 1000U);
}

}  // namespace
}  // namespace softcd::test
