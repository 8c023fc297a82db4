#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "body_pairs.hpp"
#include "softcd/mesh/features.hpp"

// Intersections that a change of a mesh would make are compared with rational arithmetic, and with the scene after the
// change.
namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A change that owns its data.
struct Change {
  BodyId body;
  std::vector<std::uint32_t> removed;
  std::vector<Triangle> added;
  Positions3 new_vertices;

  ProbeChange query() const { return {body, removed, added, new_vertices}; }
};

std::vector<ProbeChange> queries_of(const std::vector<Change>& changes) {
  std::vector<ProbeChange> queries;
  for (const Change& change : changes) queries.push_back(change.query());
  return queries;
}

/// Added triangle, body (kNoIndex: added), triangle.
using Found = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;

std::vector<Found> as_tuples(Span<const ChangeIntersection> found) {
  std::vector<Found> tuples;
  for (const ChangeIntersection& pair : found) tuples.emplace_back(pair.added, pair.body.value, pair.triangle);
  return tuples;
}

std::vector<Found> expected_of(const ProbedBodies& probed, const std::vector<PlacedTriangle>& triangles,
                               const Change& change) {
  const SceneBody& body = probed.bodies[change.body.value];
  Positions3 x = body.x_t1;
  x.insert(x.end(), change.new_vertices.begin(), change.new_vertices.end());
  const auto corners = [&](const Triangle& t) { return TriangleCorners{x[t.v[0]], x[t.v[1]], x[t.v[2]]}; };
  const std::set<std::uint32_t> removed(change.removed.begin(), change.removed.end());
  std::vector<Found> found;
  for (std::uint32_t i = 0; i < change.added.size(); ++i) {
    const Triangle own = change.added[i];
    for (const PlacedTriangle& other : triangles) {
      const bool is_own_body = other.body == change.body;
      if (is_own_body && removed.count(other.index) > 0) continue;
      const Triangle vertices = probed.bodies[other.body.value].triangles[other.index];
      if (intersect_exactly(corners(own), own, corners_of(other), vertices, is_own_body)) {
        found.emplace_back(i, other.body.value, other.index);
      }
    }
    for (std::uint32_t j = i + 1; j < change.added.size(); ++j) {
      if (intersect_exactly(corners(own), own, corners(change.added[j]), change.added[j], true)) {
        found.emplace_back(i, kNoIndex, j);
      }
    }
  }
  return found;
}

Change random_change(Random& random, const ProbedBodies& probed, double extent) {
  Change change;
  change.body = probed.ids[random.below(static_cast<std::uint32_t>(probed.ids.size()))];
  const SceneBody& body = probed.bodies[change.body.value];
  const auto vertex_count = static_cast<std::uint32_t>(body.x_t1.size());
  const auto triangle_count = static_cast<std::uint32_t>(body.triangles.size());
  for (std::uint32_t i = random.below(12); i > 0; --i) change.removed.push_back(random.below(triangle_count));
  for (std::uint32_t i = random.below(4); i > 0; --i) {
    const Vec3d nearby = body.x_t1[random.below(vertex_count)];
    const Vec3d x = random.chance(0.3) ? nearby : nearby + random.in_box(0.1 * extent);
    change.new_vertices.push_back(vec3_cast<double>(vec3_cast<float>(x)));
  }
  const auto all = vertex_count + static_cast<std::uint32_t>(change.new_vertices.size());
  for (std::uint32_t i = random.below(6); i > 0; --i) {
    const Triangle& nearby = body.triangles[random.below(triangle_count)];
    const auto corner = [&](int i_corner) {
      return random.chance(0.6) ? nearby.v[i_corner] : (random.chance(0.7) ? all - 1 : random.below(all));
    };
    change.added.push_back({{corner(0), corner(1), corner(2)}});
  }
  return change;
}

TEST(MeshChanges, intersect_what_rational_arithmetic_says) {
  std::size_t with_scene = 0;
  std::size_t with_added = 0;
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    Random random(21);
    std::vector<Change> changes;
    for (int i = 0; i < 40; ++i) changes.push_back(random_change(random, probed, extent));
    changes.push_back({probed.ids[0], {}, {}, {}});
    const AnswerLists<ChangeIntersection> found = probed.probe.intersections_after(queries_of(changes));
    ASSERT_EQ(found.size(), changes.size());
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const std::vector<Found> expected = expected_of(probed, triangles, changes[i]);
      ASSERT_EQ(as_tuples(found[i]), expected) << "change " << i;
      for (const auto& [added, body, triangle] : expected) ++(body == kNoIndex ? with_added : with_scene);
    }
  }
  EXPECT_GT(with_scene, 1000U);
  EXPECT_GT(with_added, 50U);
}

/// A strip of two triangles on the edge from 0 to 1, and a triangle of another body that stands near it.
ProbedBodies edge_and_blade(double blade_x) {
  const Mesh strip = {{{{0, 1, 2}}, {{1, 0, 3}}}, {{0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}}};
  const Mesh blade = {{{{0, 1, 2}}}, {{blade_x, -0.25, 0.5}, {blade_x, 0.25, 0.5}, {blade_x, 0, 2}}};
  return ProbedBodies({still(strip, {}), still(blade, {})});
}

/// The edge is split, and the new vertex lifted.
Change split(BodyId body, double height) {
  return {body, {0, 1}, {{{0, 4, 2}}, {{4, 1, 2}}, {{1, 4, 3}}, {{4, 0, 3}}}, {{0, 0, height}}};
}

TEST(MeshChanges, of_edges_that_are_split_or_flipped_name_what_they_would_meet) {
  ProbedBodies probed = edge_and_blade(0.0);
  const BodyId strip = probed.ids[0];
  Probe& probe = probed.probe;
  EXPECT_THAT(as_tuples(probe.intersections_after(split(strip, 0.25).query())), IsEmpty());
  EXPECT_THAT(as_tuples(probe.intersections_after(split(strip, 1.0).query())),
              ElementsAre(Found{0, 1, 0}, Found{1, 1, 0}, Found{2, 1, 0}, Found{3, 1, 0}));
  EXPECT_THAT(as_tuples(probe.intersections_after(split(strip, 0.5).query())),
              ElementsAre(Found{0, 1, 0}, Found{1, 1, 0}, Found{2, 1, 0}, Found{3, 1, 0}))
      << "what touches intersects";
  const Change flip = {strip, {0, 1}, {{{2, 0, 3}}, {{3, 1, 2}}}, {}};
  EXPECT_THAT(as_tuples(probe.intersections_after(flip.query())), IsEmpty());
  EXPECT_FALSE(probe.has_intersections()) << "nothing was changed";
}

TEST(MeshChanges, meet_all_but_the_triangles_that_they_remove) {
  Mesh stack;
  for (std::uint32_t i = 0; i < 9; ++i) stack = joined(stack, moved(one_triangle(), {0, 0, 2.0 * i}));
  ProbedBodies probed({still(moved(outward_ball(1, 1.0), {9, 9, 9}), {}), still(stack, {})});
  const auto found_without = [&](const std::vector<std::uint32_t>& removed) {
    Change blade = {probed.ids[1], removed, {{{27, 28, 29}}}, {{0.25, 0.25, -9}, {0.25, 0.5, -9}, {0.25, 0.25, 99}}};
    std::vector<std::uint32_t> triangles;
    for (const ChangeIntersection& one : probed.probe.intersections_after(blade.query())) {
      EXPECT_EQ(one.body, probed.ids[1]);
      triangles.push_back(one.triangle);
    }
    return triangles;
  };
  EXPECT_THAT(found_without({}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  for (std::uint32_t i = 0; i < 9; ++i) {
    EXPECT_EQ(found_without({i}).size(), 8U);
    EXPECT_THAT(found_without({i}), testing::Not(testing::Contains(i)));
  }
  EXPECT_THAT(found_without({8, 0, 5, 5, 3}), ElementsAre(1, 2, 4, 6, 7));
  EXPECT_THAT(found_without({7, 6, 5, 4, 3, 2, 1, 0}), ElementsAre(8));
}

TEST(MeshChanges, leave_out_what_the_filter_does) {
  ProbedBodies probed = edge_and_blade(0.0);
  probed.probe.set_body_filter([&](BodyId body) { return body != probed.ids[1]; });
  EXPECT_THAT(as_tuples(probed.probe.intersections_after(split(probed.ids[0], 1.0).query())), IsEmpty());
  probed.probe.set_body_filter([&](BodyId body) { return body != probed.ids[0]; });
  EXPECT_EQ(probed.probe.intersections_after(split(probed.ids[0], 1.0).query()).size(), 4U);
}

/// The triangle's longest side is split, with a vertex off the surface.
Change random_split(Random& random, const SceneBody& body, BodyId id, double height) {
  Change change;
  change.body = id;
  const Triangle t = body.triangles[random.below(static_cast<std::uint32_t>(body.triangles.size()))];
  const auto added = static_cast<std::uint32_t>(body.x_t1.size());
  const Vec3d middle = 0.5 * (body.x_t1[t.v[0]] + body.x_t1[t.v[1]]);
  const Vec3d x = middle + random.uniform(0, height) * random.direction();
  change.new_vertices.push_back(vec3_cast<double>(vec3_cast<float>(x)));
  for (std::uint32_t i = 0; i < body.triangles.size(); ++i) {
    const Triangle other = body.triangles[i];
    if (!has_vertex(other, t.v[0]) || !has_vertex(other, t.v[1])) continue;
    change.removed.push_back(i);
    for (const std::uint32_t replaced : {t.v[0], t.v[1]}) {
      Triangle half = other;
      for (std::uint32_t& v : half.v) {
        if (v == replaced) v = added;
      }
      change.added.push_back(half);
    }
  }
  return change;
}

SceneBody changed(const SceneBody& body, const Change& change) {
  SceneBody result = body;
  const std::set<std::uint32_t> removed(change.removed.begin(), change.removed.end());
  result.triangles.clear();
  for (std::uint32_t i = 0; i < body.triangles.size(); ++i) {
    if (removed.count(i) == 0) result.triangles.push_back(body.triangles[i]);
  }
  result.triangles.insert(result.triangles.end(), change.added.begin(), change.added.end());
  for (Positions3* const x : {&result.x_t0, &result.x_t1}) {
    x->insert(x->end(), change.new_vertices.begin(), change.new_vertices.end());
  }
  return result;
}

/// A remesher that tests before it commits: the mesh stays free of intersections, and each refused change would have
/// made some.
TEST(MeshChanges, that_are_made_are_what_was_said) {
  Mesh sheets = joined(grid_cloth(7, 7, 0.25), moved(grid_cloth(7, 7, 0.25), {0.03125, 0.0625, 0.125}));
  ProbedBodies probed({still(sheets, {})});
  SceneBody body = probed.bodies[0];
  Random random(5);
  ASSERT_FALSE(probed.probe.has_intersections());
  int made = 0;
  int refused = 0;
  for (int round = 0; round < 200; ++round) {
    const Change change = random_split(random, body, probed.ids[0], 0.3);
    const std::size_t expected = probed.probe.intersections_after(change.query()).size();
    const SceneBody next = changed(body, change);
    probed.scene.update_body(probed.ids[0], desc_of(next));
    probed.scene.set_positions(probed.ids[0], next.x_t0, next.x_t1);
    ASSERT_EQ(probed.probe.intersections().size(), expected) << "round " << round;
    if (expected == 0) {
      body = next;
      ++made;
      continue;
    }
    ++refused;
    probed.scene.update_body(probed.ids[0], desc_of(body));
    probed.scene.set_positions(probed.ids[0], body.x_t0, body.x_t1);
  }
  EXPECT_GT(made, 40);
  EXPECT_GT(refused, 40);
}

TEST(MeshChanges, that_are_out_of_range_are_errors) {
  ProbedBodies probed = edge_and_blade(0.0);
  const BodyId strip = probed.ids[0];
  const auto message_of = [&](const Change& change) {
    const std::vector<Change> changes = {split(strip, 0.25), change};
    try {
      probed.probe.intersections_after(queries_of(changes));
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("nothing is wrong");
  };
  EXPECT_THAT(message_of({BodyId{9}, {}, {}, {}}), HasSubstr("change 1: body 9 is not in the scene"));
  EXPECT_THAT(message_of({BodyId(), {}, {}, {}}), HasSubstr("is not in the scene"));
  EXPECT_THAT(message_of({strip, {2}, {}, {}}), HasSubstr("change 1 of body 0: triangle 2 is to be removed"));
  EXPECT_THAT(message_of({strip, {}, {{{0, 1, 4}}}, {}}), HasSubstr("added triangle 0 has vertex index 4"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of({strip, {}, {{{0, 1, 4}}}, {{0, 0, nan}}}), HasSubstr("new vertex 0 is not finite"));
  const BodyId absent = probed.scene.add_body(desc_of(probed.bodies[0]));
  EXPECT_THAT(message_of({absent, {}, {{{0, 1, 2}}}, {}}), HasSubstr("it has no positions"));
  EXPECT_EQ(message_of(split(strip, 0.5)), "nothing is wrong");
}

}  // namespace
}  // namespace softcd::test
