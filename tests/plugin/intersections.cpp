#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

#include "body_pairs.hpp"

// Compares intersecting triangles of bodies with rational arithmetic on all pairs.
namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns a sheet that is turned so that it lies in one plane, but along no axis.
Mesh slanted_sheet(double offset) {
  Mesh mesh = grid_cloth(6, 6, 0.25);
  for (Vec3d& x : mesh.positions) x = {x.x + offset, x.y, 0.5 * x.x - 0.25 * x.y};
  return mesh;
}

/// Returns a sheet exactly in one plane, with coordinates so long that their determinants are not doubles.
Mesh sheet_of_long_numbers(int offset) {
  Mesh mesh = grid_cloth(6, 6, 1.0);
  int i = 0;
  for (Vec3d& x : mesh.positions) {
    const int column = i % 6;
    const int row = i / 6;
    const double along = 2 * column + offset;
    const double across = 2 * row + offset;
    x = along * Vec3d{700001, 312347, 123457} + across * Vec3d{-400009, 654323, 298723};
    ++i;
  }
  return mesh;
}

/// Rounds all positions to float32.
void round_positions(Scene& bodies) {
  for (SceneBody& body : bodies) {
    for (Positions3* const x : {&body.x_t0, &body.x_t1}) {
      for (Vec3d& p : *x) p = vec3_cast<double>(vec3_cast<float>(p));
    }
  }
}

/// Returns two bodies of `count` triangles each, with coordinates up to 40. The first corner of triangle i of one body
/// is within 1e-9 of triangle i of the other body: beside it, or beyond it.
Scene close_triangles(std::uint32_t count) {
  Random random(17);
  Mesh meshes[2];
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t row = i / 10 % 10;
    const std::uint32_t layer = i / 100;
    const Vec3d place = {10.0 + 3.0 * (i % 10), 10.0 + 3.0 * row, 10.0 + 3.0 * layer};
    const Vec3d normal = random.direction();
    const Vec3d along = cross(normal, random.direction());
    const Vec3d across = cross(normal, along);
    const Vec3d apex = place + random.uniform(-1e-9, 1e-9) * normal;
    meshes[0].positions.insert(meshes[0].positions.end(), {place + along, place - along + across, place - across});
    meshes[1].positions.insert(meshes[1].positions.end(), {apex, apex + normal + 0.25 * along, apex + normal});
    for (Mesh& mesh : meshes) mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
  }
  return {still(meshes[0], {}), still(meshes[1], {})};
}

/// Returns the number of intersections that are not among others.
std::size_t count_of_others(const std::vector<Intersection>& all, const std::vector<Intersection>& others) {
  std::vector<Intersection> rest;
  std::set_difference(all.begin(), all.end(), others.begin(), others.end(), std::back_inserter(rest));
  return rest.size();
}

std::vector<NamedScene> entangled_scenes() {
  std::vector<NamedScene> scenes = odd_scenes();
  const Mesh ball = outward_ball(2, 1.0);
  scenes.push_back({"balls in each other", {still(ball, {}), still(moved(ball, {0.5, 0.25, 0}), {})}});
  scenes.push_back({"a crumpled cloth", {still(crumpled_cloth(16, 14, 0.25, 0.05, 5), {})}});
  scenes.push_back({"sheets in one slanted plane",
                    {still(slanted_sheet(0), {}), still(slanted_sheet(0.25), {}), still(slanted_sheet(0.125), {})}});
  scenes.push_back({"sheets of long numbers in one plane",
                    {still(sheet_of_long_numbers(0), {}), still(sheet_of_long_numbers(1), {})}});
  for (NamedScene& named : scenes) round_positions(named.bodies);
  return scenes;
}

/// Returns the intersections that a question is about, in its order.
std::vector<Intersection> asked_of(const std::vector<Intersection>& all, ProbeBodies pair) {
  std::vector<Intersection> asked;
  const auto is = [](BodyId id, std::uint32_t body) { return id == BodyId() || id.value == body; };
  for (const auto& [body_a, a, body_b, b] : all) {
    const bool is_within = body_a == body_b;
    if (is_within && pair.a != pair.b) continue;
    if (is(pair.a, body_a) && is(pair.b, body_b)) {
      asked.emplace_back(body_a, a, body_b, b);
    } else if (is(pair.a, body_b) && is(pair.b, body_a)) {
      asked.emplace_back(body_b, b, body_a, a);
    }
  }
  std::sort(asked.begin(), asked.end());
  return asked;
}

std::vector<ProbeBodies> all_questions(const std::vector<BodyId>& ids) {
  std::vector<ProbeBodies> questions = {{}};
  for (const BodyId a : ids) {
    questions.push_back({a, BodyId()});
    questions.push_back({BodyId(), a});
    for (const BodyId b : ids) questions.push_back({a, b});
  }
  return questions;
}

TEST(Intersections, are_those_of_rational_arithmetic) {
  std::size_t count = 0;
  std::vector<NamedScene> scenes = entangled_scenes();
  const Mesh ball = icosphere(2, 1.0 / 3.0);
  scenes.push_back({"balls of doubles", {still(ball, {}), still(moved(ball, {0.1, 0.2, 0}), {})}});
  scenes.push_back({"a crumpled cloth of doubles", {still(crumpled_cloth(16, 14, 0.3, 0.06, 5), {})}});
  for (NamedScene& named : scenes) {
    SCOPED_TRACE(named.name);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<Intersection> all = all_intersections(probed);
    count += all.size();
    const std::vector<ProbeBodies> questions = all_questions(probed.ids);
    const AnswerLists<TriangleIntersection> found = probed.probe.intersections(questions);
    ASSERT_EQ(found.size(), questions.size());
    for (std::size_t i = 0; i < questions.size(); ++i) {
      ASSERT_EQ(as_tuples(found[i]), asked_of(all, questions[i])) << "question " << i;
    }
    for (const ProbeBodies& pair : questions) {
      ASSERT_EQ(probed.probe.has_intersections(pair), !asked_of(all, pair).empty());
    }
  }
  EXPECT_GT(count, 2500U);
}

/// At the end of the step that is not asked about, the bodies are far apart.
TEST(Intersections, are_those_of_double_positions) {
  for (const double distance : {0.0, 1e5}) {
    for (const StepEnd end : {StepEnd::t1, StepEnd::t0}) {
      SCOPED_TRACE(testing::Message() << "at " << distance << ", " << (end == StepEnd::t0 ? "t0" : "t1"));
      Scene bodies = close_triangles(300);
      for (SceneBody& body : bodies) {
        for (Vec3d& x : body.x_t1) x.x += distance;
        body.x_t0 = body.x_t1;
      }
      for (Vec3d& x : end == StepEnd::t1 ? bodies[1].x_t0 : bodies[1].x_t1) x.z += 100;
      Scene rounded = bodies;
      round_positions(rounded);
      const std::vector<Intersection> of_floats = all_intersections(ProbedBodies(std::move(rounded)), end);
      ProbedBodies probed(std::move(bodies), end);
      const std::vector<Intersection> all = all_intersections(probed, end);
      EXPECT_GT(count_of_others(all, of_floats), 30U) << "that rounding would lose";
      EXPECT_GT(count_of_others(of_floats, all), 30U) << "that rounding would make";
      EXPECT_EQ(as_tuples(probed.probe.intersections()), all);
      EXPECT_EQ(probed.probe.has_intersections(), !all.empty());
    }
  }
}

/// Rounding makes the sheets one.
TEST(Intersections, of_sheets_in_double_that_are_apart_are_none) {
  Mesh sheet = grid_cloth(6, 6, 0.25);
  for (Vec3d& x : sheet.positions) x = x + Vec3d{10, 10, 10};
  ProbedBodies probed({still(sheet, {}), still(moved(sheet, {0.1, 0.1, 1e-9}), {})});
  EXPECT_FALSE(probed.probe.has_intersections());
  EXPECT_TRUE(probed.probe.intersections().empty());
  const Positions3 on_it = moved(sheet, {0.1, 0.1, 0}).positions;
  probed.scene.set_positions(probed.ids[1], on_it);
  EXPECT_TRUE(probed.probe.has_intersections()) << "of sheets that touch";
}

/// Nodes of the hierarchy know 16 classes of bodies.
TEST(Intersections, of_bodies_of_one_class_are_found) {
  constexpr std::uint32_t kCount = 34;
  Scene bodies;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double place = i == 16 ? 0 : i;
    bodies.push_back(still(moved(one_triangle(), {8 * place, 0, i == 16 ? 0.125 : 0}), {}));
  }
  // Opposite to the first one.
  for (Positions3* const x : {&bodies[16].x_t0, &bodies[16].x_t1}) (*x)[2] = {0.25, 0.25, -4};
  ProbedBodies probed(std::move(bodies));
  EXPECT_THAT(as_tuples(probed.probe.intersections({probed.ids[0], BodyId()})), ElementsAre(Intersection{0, 0, 16, 0}));
  EXPECT_THAT(as_tuples(probed.probe.intersections({BodyId(), probed.ids[16]})),
              ElementsAre(Intersection{0, 0, 16, 0}));
  EXPECT_THAT(as_tuples(probed.probe.intersections()), ElementsAre(Intersection{0, 0, 16, 0}));
  EXPECT_TRUE(probed.probe.has_intersections({probed.ids[16], BodyId()}));
  EXPECT_TRUE(probed.probe.has_intersections({probed.ids[0], probed.ids[16]}));
  EXPECT_TRUE(probed.probe.has_intersections({probed.ids[16], probed.ids[0]}));
  EXPECT_EQ(probed.probe.distance({probed.ids[16], BodyId()}).body_b, probed.ids[0]);
  EXPECT_EQ(probed.probe.distance({probed.ids[16], probed.ids[0]}).distance, 0);
  EXPECT_NEAR(probed.probe.distance({probed.ids[1], probed.ids[33]}).distance, 8 * 32 - 1, 1e-9);
  EXPECT_FALSE(probed.probe.has_intersections({probed.ids[1], BodyId()}));
}

TEST(Intersections, of_a_mesh_are_beyond_what_is_shared) {
  // A strip of two triangles, the second one folded onto the first one. A third triangle at a corner passes through the
  // first one or beside it.
  const std::vector<Triangle> triangles = {{{0, 1, 2}}, {{1, 0, 3}}, {{2, 4, 5}}};
  Positions3 x = {{0, 0, 0}, {4, 0, 0}, {2, 4, 0}, {2, 2, 0}, {2, 1, 1}, {2, 1, -1}};
  ProbedBodies probed({still({{triangles[0], triangles[1]}, {x.begin(), x.begin() + 4}}, {})});
  EXPECT_FALSE(probed.probe.has_intersections()) << "triangles that are joined by an edge";
  const auto count = [](std::vector<Triangle> mesh, Positions3 positions) {
    ProbedBodies one({still({std::move(mesh), std::move(positions)}, {})});
    return one.probe.intersections().size();
  };
  EXPECT_EQ(count({triangles[0], triangles[2]}, x), 1U);
  x[4] = {2, 5, 1};
  x[5] = {2, 5, -1};
  EXPECT_EQ(count({triangles[0], triangles[2]}, x), 0U);
}

TEST(Intersections, of_segments_are_where_these_touch) {
  SceneBody rope{{}, {{-1, 0, 0}, {1, 0, 0}, {1, 2, 0}}, {{-1, 0, 0}, {1, 0, 0}, {1, 2, 0}}, {}, {{{0, 1}}, {{1, 2}}}};
  SceneBody other{{}, {{0, -1, 0}, {0, 1, 0}}, {{0, -1, 0}, {0, 1, 0}}, {}, {{{0, 1}}}};
  ProbedBodies probed({rope, other, still(moved(one_triangle(), {0.75, 0.75, -0.25}), {})});
  EXPECT_THAT(as_tuples(probed.probe.intersections()), ElementsAre(Intersection{0, 0, 1, 0}, Intersection{0, 1, 2, 0}));
}

TEST(Intersections, follow_bodies_that_come_move_and_go) {
  const Mesh ball = outward_ball(2, 1.0);
  ProbedBodies probed({still(ball, {}), still(moved(ball, {5, 0, 0}), {})});
  Probe& probe = probed.probe;
  EXPECT_FALSE(probe.has_intersections());
  const Positions3 nearby = moved(ball, {0.5, 0, 0}).positions;
  probed.scene.set_positions(probed.ids[1], nearby);
  EXPECT_TRUE(probe.has_intersections());
  EXPECT_TRUE(probe.has_intersections({probed.ids[1], probed.ids[0]}));
  EXPECT_FALSE(probe.has_intersections({probed.ids[1], probed.ids[1]}));
  probe.set_body_filter([&](BodyId body) { return body == probed.ids[0]; });
  EXPECT_FALSE(probe.has_intersections({probed.ids[0], probed.ids[1]})) << "the filter leaves it out";
  EXPECT_FALSE(probe.has_intersections({probed.ids[1], probed.ids[0]}));
  probe.set_body_filter({});
  const BodyId absent = probed.scene.add_body(desc_of(probed.bodies[0]));
  EXPECT_FALSE(probe.has_intersections({absent, BodyId()})) << "a body without positions is nowhere";
  Positions3 broken = nearby;
  for (Vec3d& x : broken) x.x = std::numeric_limits<double>::quiet_NaN();
  probed.scene.set_positions(probed.ids[1], broken);
  EXPECT_FALSE(probe.has_intersections());
  EXPECT_FALSE(probe.distance({probed.ids[0], probed.ids[1]}).has_points());
  probed.scene.remove_body(probed.ids[1]);
  EXPECT_FALSE(probe.has_intersections());
}

TEST(Intersections, of_nothing_are_none) {
  softcd::Scene scene(scene_options());
  Probe probe(scene);
  EXPECT_FALSE(probe.has_intersections());
  const std::vector<ProbeBodies> questions(3);
  const AnswerLists<TriangleIntersection> found = probe.intersections(questions);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_THAT(as_tuples(found.all()), IsEmpty());
  EXPECT_EQ(probe.intersections(Span<const ProbeBodies>()).size(), 0U);
  EXPECT_FALSE(probe.distance({}).has_points());
}

TEST(Intersections, of_bodies_that_are_not_there_are_errors) {
  ProbedBodies probed({still(one_triangle(), {}), still(one_triangle(), {})});
  probed.scene.remove_body(probed.ids[1]);
  const std::vector<ProbeBodies> questions = {{}, {probed.ids[0], probed.ids[1]}};
  const auto message_of = [&](const auto& ask) {
    try {
      ask();
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const char* const expected = "pair 1: body 1 is not in the scene";
  EXPECT_THAT(message_of([&] { probed.probe.intersections(questions); }), HasSubstr(expected));
  EXPECT_THAT(message_of([&] { probed.probe.distances(questions); }), HasSubstr(expected));
  EXPECT_THAT(message_of([&] { probed.probe.has_intersections({BodyId{7}, {}}); }), HasSubstr("pair 0: body 7"));
  EXPECT_FALSE(probed.probe.has_intersections());
}

}  // namespace
}  // namespace softcd::test
