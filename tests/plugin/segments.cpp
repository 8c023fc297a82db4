#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "probing.hpp"
#include "random.hpp"
#include "softcd/math/scalar.hpp"

// Links without faces, beside triangles and alone, against brute force and by example.
namespace softcd::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<Segment> chain(std::uint32_t first, std::uint32_t count) {
  std::vector<Segment> segments;
  for (std::uint32_t i = first; i < first + count; ++i) segments.push_back({{i, i + 1}});
  return segments;
}

SceneBody rope(Positions3 x_t0, Positions3 x_t1, float margin) {
  const auto count = static_cast<std::uint32_t>(x_t1.size());
  return {{}, std::move(x_t0), std::move(x_t1), everything(margin), chain(0, count - 1)};
}

SceneBody rope(const Positions3& x, float margin) {
  return rope(x, x, margin);
}

/// Returns a random walk in a box, with steps of about that length, on a grid.
Positions3 tangle(std::uint32_t count, double length, double half_extent, std::uint64_t seed) {
  Random random(seed);
  Positions3 x{random.in_box(half_extent)};
  while (x.size() < count) {
    const Vec3d next = x.back() + random.uniform(0.5, 1.5) * length * random.direction();
    if (max_norm(next) <= half_extent) x.push_back(next);
  }
  snap_to_grid(x, 17);
  return x;
}

/// Returns triangles of all kinds with segments between any of their vertices, most of them short. Segments are new
/// edges, sides of triangles, repeated or reversed ones, and single vertices.
SceneBody mixed_soup(std::uint32_t triangles, std::uint32_t segments, std::uint64_t seed, float margin) {
  SoupOptions options;
  options.triangle_count = triangles;
  options.half_extent = 1.5;
  options.largest = 0.4;
  options.size_ratio = 8.0;
  options.degenerate_share = 0.1;
  options.joined_share = 0.4;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  SceneBody body = moving(mesh, jittered(mesh.positions, 0.2, seed + 1), everything(margin));
  snap_to_grid(body.x_t1, 17);
  Random random(seed + 2);
  const auto count = static_cast<std::uint32_t>(body.x_t1.size());
  while (body.segments.size() < segments) {
    const std::uint32_t a = random.below(count);
    const std::uint32_t b = std::min(count - 1, a + random.below(5));
    const bool is_long = norm(body.x_t1[b] - body.x_t1[a]) > 1.0;
    if (is_long && !random.chance(0.1)) continue;
    body.segments.push_back({{a, b}});
    if (random.chance(0.2)) body.segments.push_back({{b, a}});
  }
  return body;
}

Scene mixed_scene(float margin, std::uint64_t seed) {
  const Positions3 curled = tangle(160, 0.15, 1.4, seed + 20);
  Positions3 moved_on = jittered(curled, 0.15, seed + 21);
  snap_to_grid(moved_on, 17);
  return {mixed_soup(150, 120, seed, margin), mixed_soup(100, 60, seed + 10, 2 * margin),
          rope(curled, moved_on, margin)};
}

TEST(Segments, agree_with_brute_force_at_one_time) {
  for (const std::uint64_t seed : {1U, 2U}) {
    for (const BroadPhase broad_phase : {BroadPhase::exact, BroadPhase::uniform}) {
      const Scene scene = mixed_scene(0.02F, 100 * seed);
      EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd, broad_phase)), 500U);
    }
  }
}

TEST(Segments, agree_with_brute_force_on_the_way) {
  for (const std::uint64_t seed : {3U, 4U}) {
    for (const BroadPhase broad_phase : {BroadPhase::exact, BroadPhase::uniform}) {
      const Scene scene = mixed_scene(0.0F, 100 * seed);
      EXPECT_GT(expect_continuous_contacts(scene, test_options(Detection::ccd, broad_phase)), 300U);
    }
  }
}

TEST(Segments, come_within_their_margins_on_the_way) {
  Scene scene = mixed_scene(0.02F, 500);
  PipelineOptions options = test_options(Detection::ccd);
  options.accuracy = Accuracy::conservative;
  const std::vector<Contact> contacts = detect_once(scene, options);
  EXPECT_GT(contacts.size(), 500U);
  expect_nothing_missed_on_the_way(scene, contacts);
}

/// Returns segments a hundred times as long as most triangles, which are split.
Scene long_ones() {
  Random random(6);
  SceneBody hairs{{}, {}, {}, everything(0.01F)};
  for (std::uint32_t i = 0; i < 40; ++i) {
    hairs.x_t1.push_back(random.in_box(4.0));
    hairs.x_t1.push_back(random.in_box(4.0));
    hairs.segments.push_back({{2 * i, 2 * i + 1}});
  }
  snap_to_grid(hairs.x_t1, 17);
  hairs.x_t0 = hairs.x_t1;
  SoupOptions dust;
  dust.triangle_count = 6000;
  dust.largest = 0.1;
  dust.seed = 7;
  return {hairs, still(triangle_soup(dust), everything(0.01F))};
}

TEST(Segments, are_split_where_they_are_long) {
  const Scene scene = long_ones();
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 100U);
  const Outcome outcome = outcome_of(scene, test_options(Detection::dcd));
  EXPECT_GT(outcome.statistics.split_triangles, 10U);
  PipelineOptions whole = test_options(Detection::dcd);
  whole.subdivision = false;
  EXPECT_TRUE(identical(outcome.contacts, detect_once(scene, whole)));
}

// Slabs are for faces, and segments have none.
TEST(Segments, touch_by_distance_whatever_the_rule) {
  const Scene scene = mixed_scene(0.02F, 800);
  PipelineOptions options = test_options(Detection::dcd);
  const std::vector<Contact> by_distance = detect_once(scene, options);
  options.contact_rule = ContactRule::slab;
  const std::vector<Contact> by_slab = detect_once(scene, options);
  const auto edges_of_all = [](const std::vector<Contact>& contacts) {
    std::vector<Contact> edges;
    for (const Contact& contact : contacts) {
      if (contact.kind == ContactKind::edge_edge) edges.push_back(contact);
    }
    return edges;
  };
  EXPECT_TRUE(identical(edges_of_all(by_distance), edges_of_all(by_slab)));
  for (const Contact& contact : by_slab) {
    if (contact.kind == ContactKind::vertex_triangle) {
      EXPECT_LT(contact.feature_b, scene[contact.body_b.value].triangles.size());
    }
  }
}

TEST(Segments, are_numbered_behind_the_edges_of_triangles) {
  const Positions3 x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {5, 1, 0}, {6, 1, 0}};
  SceneBody body{{{{0, 1, 2}}}, x, x, everything(0.01F)};
  body.settings.self_collision = false;
  body.segments = {{{4, 5}}, {{2, 1}}, {{4, 3}}, {{5, 4}}, {{0, 3}}};
  const Positions3 across = {{5.5, 1, -1}, {5.5, 1, 1}, {5, 0.5, -1},   {5, 0.5, 1},
                             {3, 0, -1},   {3, 0, 1},   {0.5, 0.5, -1}, {0.5, 0.5, 1}};
  SceneBody needles{{}, across, across, everything(0.01F), {{{0, 1}}, {{2, 3}}, {{4, 5}}, {{6, 7}}}};
  const std::vector<Contact> contacts = detect_once({body, needles}, test_options(Detection::dcd));
  // Sides of the triangle are edges 0 to 2: {0, 1}, {0, 2}, {1, 2}.
  const std::vector<FeaturePair> expected = {{ContactKind::edge_edge, 0, 2, 1, 3},
                                             {ContactKind::edge_edge, 0, 3, 1, 0},
                                             {ContactKind::edge_edge, 0, 4, 1, 1},
                                             {ContactKind::edge_edge, 0, 5, 1, 2}};
  EXPECT_EQ(features_of(contacts), expected);
  ASSERT_EQ(contacts.size(), 4U);
  EXPECT_THAT(contacts[2].vertices, testing::ElementsAre(3, 4, 2, 3));
}

TEST(Segments, of_a_rope_are_numbered_as_they_were_given) {
  const Positions3 x = {{3, 0, 0}, {2, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  const SceneBody first{{}, x, x, everything(0.01F), {{{2, 3}}, {{0, 1}}, {{2, 1}}}};
  const Positions3 over = {{0.5, 0, -1}, {0.5, 0, 1}};
  const std::vector<Contact> contacts = detect_once({first, rope(over, 0.01F)}, test_options(Detection::dcd));
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].feature_a, 0U);
  EXPECT_FLOAT_EQ(contacts[0].weights[0], 0.5F);
}

TEST(Segments, touch_triangles_with_vertices_and_their_sides_with_edges) {
  const Mesh triangle{{{{0, 1, 2}}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const auto kinds = [&](const Positions3& x) {
    std::string found;
    const Scene scene{still(triangle, everything(0.1F)), rope(x, 0.1F)};
    for (const Contact& contact : detect_once(scene, test_options(Detection::dcd))) {
      found += contact.kind == ContactKind::edge_edge ? "e" : contact.body_a == BodyId{1} ? "v" : "?";
    }
    return found;
  };
  EXPECT_EQ(kinds({{1, 1, 0.1}, {1, 1, 3}}), "v") << "an end on the face";
  EXPECT_EQ(kinds({{1, 1, 0.1}, {1.5, 1, 0.1}}), "vv") << "flat on the face";
  EXPECT_EQ(kinds({{2, -1, 0.1}, {2, 1, 0.1}}), "ve") << "over a side";
  EXPECT_EQ(kinds({{-1, -1, 0.1}, {1, -1, 0.1}}), "") << "beside";
  EXPECT_EQ(kinds({{-1, 1, 0.1}, {1, -1, 0.1}}), "ee") << "over a corner: with both sides that end there";
}

TEST(Segments, do_not_touch_neighbours) {
  const Positions3 zigzag = {{0, 0, 0}, {1, 0, 0}, {0, 0.01, 0}, {1, 0.01, 0}, {0, 0.02, 0}};
  const std::vector<Contact> contacts = detect_once({rope(zigzag, 0.1F)}, test_options(Detection::dcd));
  std::vector<FeaturePair> expected;
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t j = i + 2; j < 4; ++j) expected.push_back({ContactKind::edge_edge, 0, i, 0, j});
  }
  EXPECT_EQ(features_of(contacts), expected);
}

// Too many segments around one vertex to be listed, and few, with triangles among them.
TEST(Segments, of_a_hub_agree_with_brute_force) {
  for (const std::uint32_t count : {16U, 400U}) {
    Random random(count);
    SceneBody body{{}, {{0, 0, 0}}, {}, everything(0.01F)};
    for (std::uint32_t i = 1; i <= count; ++i) {
      body.x_t0.push_back(random.uniform(0.2, 1.0) * random.direction());
      body.segments.push_back({{0, i}});
      if (i % 8 == 0) body.triangles.push_back({{0, i - 1, i}});
      if (i % 6 == 0) body.segments.push_back({{i - 1, i}});
    }
    snap_to_grid(body.x_t0, 17);
    body.x_t1 = body.x_t0;
    EXPECT_GE(expect_discrete_contacts({body}, test_options(Detection::dcd)), count / 20);
  }
}

TEST(Segments, change_nothing_where_they_are_there_already) {
  Scene scene{
      still(crumpled_cloth(20, 16, 0.1, 0.04, 2), everything(0.01F)),
      moving(grid_cloth(8, 8, 0.2), translated(grid_cloth(8, 8, 0.2).positions, {0.1, 0, 0.2}), everything(0.01F))};
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const std::vector<Contact> expected = detect_once(scene, test_options(detection));
    EXPECT_GT(expected.size(), 100U);
    Scene with = scene;
    for (SceneBody& body : with) {
      for (const Edge& edge : edges_of(body.triangles)) body.segments.push_back({{edge.v[1], edge.v[0]}});
      body.segments.push_back({{3, 3}});
    }
    EXPECT_TRUE(identical(expected, detect_once(with, test_options(detection))));
  }
}

TEST(Segments, without_length_are_points) {
  const Mesh floor{{{{0, 1, 2}}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  SceneBody points{{}, {{1, 1, 0.05}, {1, 1, 0.05}, {0.5, 0.5, 0.05}}, {}, everything(0.05F), {{{0, 1}}, {{2, 2}}}};
  points.x_t1 = points.x_t0;
  const std::vector<Contact> contacts =
      detect_once({still(floor, everything(0.05F)), points}, test_options(Detection::dcd));
  const std::vector<FeaturePair> expected = {{ContactKind::vertex_triangle, 1, 0, 0, 0},
                                             {ContactKind::vertex_triangle, 1, 1, 0, 0},
                                             {ContactKind::vertex_triangle, 1, 2, 0, 0}};
  EXPECT_EQ(features_of(contacts), expected);
  // The point is an edge without length, which is near other edges.
  const Positions3 beside = {{0, 1, 0.1}, {2, 1, 0.1}};
  const std::vector<Contact> edges = detect_once({points, rope(beside, 0.05F)}, test_options(Detection::dcd));
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(features_of(edges[0]), (FeaturePair{ContactKind::edge_edge, 0, 0, 1, 0}));
}

// Features of a left out triangle pass to segments, and from these to others.
TEST(Segments, with_vertices_that_are_not_finite_are_left_out) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Scene scene = mixed_scene(detection == Detection::dcd ? 0.02F : 0.0F, 900);
    // Sides of triangles that will be left out.
    for (std::uint32_t t = 0; t < 40; ++t)
      scene[0].segments.push_back({{scene[0].triangles[t].v[0], scene[0].triangles[t].v[1]}});
    for (std::uint32_t t = 0; t < 40; t += 3) scene[0].x_t1[scene[0].triangles[t].v[2]].y = kNaN;
    scene[2].x_t0[50].x = INFINITY;
    scene[2].x_t1[50] = scene[2].x_t0[50];
    scene[2].x_t1[80].z = kNaN;
    if (detection == Detection::dcd) {
      EXPECT_GT(expect_discrete_contacts(scene, test_options(detection)), 200U);
    } else {
      EXPECT_GT(expect_continuous_contacts(scene, test_options(detection)), 100U);
    }
  }
}

TEST(Segments, come_and_go_with_updates) {
  const Scene bodies = mixed_scene(0.02F, 1000);
  LoadedScene loaded = load(bodies, test_options(Detection::dcd));
  Scene now = bodies;
  for (const std::size_t step : {1U, 2U, 0U, 1U}) {
    // Body 0 becomes another one, with more or fewer triangles and segments, or without.
    now[0] = bodies[step];
    if (step == 2) now[0].triangles = {{{0, 1, 2}}};
    const auto count = static_cast<std::uint32_t>(now[0].x_t1.size());
    loaded.pipeline.scene.update_body(loaded.ids[0], {now[0].triangles, count, now[0].settings, -1, now[0].segments});
    loaded.pipeline.scene.set_positions(loaded.ids[0], now[0].x_t0, now[0].x_t1);
    const std::vector<Contact> expected = detect_once(now, test_options(Detection::dcd));
    EXPECT_GT(expected.size(), 100U);
    EXPECT_TRUE(identical(expected, loaded.pipeline.detect()));
  }
}

TEST(Segments, are_what_kinds_of_features_say) {
  Scene scene{rope(tangle(100, 0.2, 0.8, 30), 0.02F), still(crumpled_cloth(12, 12, 0.1, 0.05, 3), everything(0.02F))};
  scene[0].settings.features = {true, false};
  std::size_t count = 0;
  for (const Contact& contact : detect_once(scene, test_options(Detection::dcd))) {
    EXPECT_FALSE(contact.kind == ContactKind::edge_edge && contact.body_a == BodyId{0});
    count += contact.body_a == BodyId{0} || contact.body_b == BodyId{0} ? 1U : 0U;
  }
  EXPECT_GT(count, 0U);
}

TEST(Segments, out_of_range_are_named) {
  CollisionPipeline pipeline(test_options(Detection::dcd));
  const Positions3 x = {{0, 0, 0}, {1, 0, 0}};
  const BodyId body = pipeline.scene.add_body({{}, 2, everything(0.1F), -1, chain(0, 1)});
  const std::vector<Segment> segments = {{{0, 1}}, {{1, 0}}, {{1, 2}}};
  const std::string added = error_of([&] { pipeline.scene.add_body({{}, 2, {}, -1, segments}); });
  EXPECT_THAT(added, AllOf(HasSubstr("segment 2"), HasSubstr("index 2"), HasSubstr("2 vertices")));
  const std::string updated = error_of([&] { pipeline.scene.update_body(body, {{}, 2, {}, -1, segments}); });
  EXPECT_THAT(updated, AllOf(HasSubstr("body " + std::to_string(body.value)), HasSubstr("segment 2")));
  const BodyId other = pipeline.scene.add_body({{}, 2, everything(0.1F), -1, chain(0, 1)});
  pipeline.scene.set_positions(body, x);
  pipeline.scene.set_positions(other, x);
  EXPECT_EQ(pipeline.detect().size(), 1U) << "the body is what it was";
}

TEST(Segments, are_near_points_and_in_spheres_but_in_no_rays_way) {
  Mesh ball = outward_ball(2, 1.0);
  SceneBody hairy = still(ball, everything(0.0F));
  const auto count = static_cast<std::uint32_t>(ball.positions.size());
  hairy.x_t1.push_back({3, 0, 0});
  hairy.x_t1.push_back({2, 0, 0});
  hairy.x_t0 = hairy.x_t1;
  hairy.segments = {{{count, count + 1}}};
  const auto hair = static_cast<std::uint32_t>(ball.triangles.size());
  ProbedBodies probed({hairy});
  const ClosestPoint on_hair = probed.probe.closest_point({{2.5, 0.25, 0}});
  EXPECT_EQ(on_hair.triangle, hair);
  EXPECT_EQ(on_hair.side, 0);
  EXPECT_DOUBLE_EQ(on_hair.distance, 0.25);
  EXPECT_FLOAT_EQ(on_hair.weights[0], 0.5F);
  EXPECT_EQ(probed.probe.closest_point({{0, 1.5, 0}}).side, 1) << "the ball is closed all the same";
  EXPECT_EQ(probed.probe.closest_point({{0, 0.5, 0}}).side, -1);
  const std::vector<ProbeSphere> spheres = {{{2.5, 0.25, 0}, 0.3}, {{2.5, 0.25, 0}, 0.2}};
  const AnswerLists<TriangleOverlap> overlaps = probed.probe.overlaps(spheres);
  ASSERT_EQ(overlaps[0].size(), 1U);
  EXPECT_EQ(overlaps[0][0].triangle, hair);
  EXPECT_EQ(overlaps[1].size(), 0U);
  EXPECT_FALSE(probed.probe.first_hit({{2.5, 0, -1}, {0, 0, 1}}).has_hit());
  EXPECT_NE(probed.probe.first_hit({{4, 0, 0}, {-1, 0, 0}}).triangle, hair) << "along the hair";
}

}  // namespace
}  // namespace softcd::test
