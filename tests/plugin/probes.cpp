#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "probing.hpp"

// Results of a probe in a scene that changes, and its errors.
namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Returns the bodies that a line along z through the origin meets, from above.
std::vector<std::uint32_t> bodies_below(Probe& probe) {
  const Ray ray{{0.3, 0.4, 100}, {0, 0, -1}};
  const AnswerLists<RayHit> hits = probe.all_hits({&ray, 1});
  std::vector<std::uint32_t> bodies;
  for (const RayHit& hit : hits[0]) bodies.push_back(hit.body.value);
  return bodies;
}

double height_below(Probe& probe) {
  return 100 - probe.first_hit({{0.3, 0.4, 100}, {0, 0, -1}}).t;
}

SceneBody sheet(double height) {
  return still(moved(grid_cloth(4, 4, 0.5), {0, 0, height}), {});
}

TEST(Probes, see_bodies_come_move_and_go) {
  ProbedBodies probed({sheet(1), sheet(2)});
  Probe& probe = probed.probe;
  softcd::Scene& scene = probed.scene;
  EXPECT_THAT(bodies_below(probe), ElementsAre(1U, 0U));
  const Positions3 higher = sheet(3).x_t1;
  scene.set_positions(probed.ids[0], higher);
  EXPECT_THAT(bodies_below(probe), ElementsAre(0U, 1U));
  EXPECT_EQ(height_below(probe), 3);
  const SceneBody third = sheet(4);
  const BodyId added = scene.add_body(desc_of(third));
  EXPECT_THAT(bodies_below(probe), ElementsAre(0U, 1U)) << "a body without positions is nowhere";
  scene.set_positions(added, third.x_t1);
  EXPECT_THAT(bodies_below(probe), ElementsAre(2U, 0U, 1U));
  scene.remove_body(probed.ids[0]);
  EXPECT_THAT(bodies_below(probe), ElementsAre(2U, 1U));
  const SceneBody other = still(moved(grid_cloth(7, 7, 0.3), {0, 0, 0.5}), {});
  scene.update_body(added, desc_of(other));
  EXPECT_THAT(bodies_below(probe), ElementsAre(1U));
  scene.set_positions(added, other.x_t1);
  EXPECT_THAT(bodies_below(probe), ElementsAre(1U, 2U));
  scene.remove_body(added);
  scene.remove_body(probed.ids[1]);
  EXPECT_TRUE(bodies_below(probe).empty());
}

TEST(Probes, look_at_either_end_of_the_step) {
  Scene bodies{sheet(1)};
  bodies[0].x_t1 = translated(bodies[0].x_t0, {0, 0, 5});
  ProbedBodies probed(bodies);
  Probe at_t0(probed.scene, {StepEnd::t0});
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(height_below(probed.probe), 6);
    EXPECT_EQ(height_below(at_t0), 1);
  }
  const Positions3 lower = sheet(-1).x_t1;
  probed.scene.set_positions(probed.ids[0], lower, bodies[0].x_t1);
  EXPECT_EQ(height_below(at_t0), -1);
  EXPECT_EQ(height_below(probed.probe), 6);
  probed.probe.set_options({StepEnd::t0});
  EXPECT_EQ(height_below(probed.probe), -1);
}

TEST(Probes, leave_out_what_the_filter_does) {
  ProbedBodies probed({sheet(1), sheet(2), sheet(3)});
  std::vector<std::uint32_t> asked;
  probed.probe.set_body_filter([&](BodyId body) {
    asked.push_back(body.value);
    return body.value != 1;
  });
  EXPECT_THAT(bodies_below(probed.probe), ElementsAre(2U, 0U));
  EXPECT_THAT(asked, ElementsAre(0U, 1U, 2U));
  probed.probe.set_body_filter({});
  EXPECT_THAT(bodies_below(probed.probe), ElementsAre(2U, 1U, 0U));
  struct Problem {};
  probed.probe.set_body_filter([](BodyId /*body*/) -> bool { throw Problem(); });
  EXPECT_THROW(bodies_below(probed.probe), Problem);
  probed.probe.set_body_filter({});
  EXPECT_THAT(bodies_below(probed.probe), ElementsAre(2U, 1U, 0U));
}

TEST(Probes, leave_out_triangles_that_are_not_finite) {
  ProbedBodies probed({sheet(1), sheet(2)});
  std::vector<std::string> warnings;
  probed.scene.set_log([&](LogLevel /*level*/, std::string_view text) { warnings.emplace_back(text); });
  Positions3 broken = probed.bodies[1].x_t1;
  broken[10].x = std::numeric_limits<double>::quiet_NaN();
  probed.scene.set_positions(probed.ids[1], broken);
  EXPECT_THAT(bodies_below(probed.probe), ElementsAre(0U));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("body 1: vertex 10 is not finite"));
  const ProbePoint corner{{0.25, 0.25, 2}};
  const ClosestPoint closest = probed.probe.closest_point(corner);
  EXPECT_GT(closest.distance, 0.3);
  probed.scene.set_positions(probed.ids[1], probed.bodies[1].x_t1);
  EXPECT_THAT(bodies_below(probed.probe), ElementsAre(1U, 0U));
}

TEST(Probes, share_a_scene_with_detections) {
  ProbedBodies probed({sheet(1), sheet(1.01)});
  for (std::size_t b = 0; b < 2; ++b) probed.scene.set_settings(probed.ids[b], everything(0.02F));
  Query query(probed.scene, {});
  const std::vector<Contact> expected = copy_of(query.detect());
  ASSERT_FALSE(expected.empty());
  for (int round = 0; round < 3; ++round) {
    Ticket ticket = query.start();
    EXPECT_THAT(bodies_below(probed.probe), ElementsAre(1U, 0U));
    EXPECT_TRUE(identical(expected, ticket.wait()));
    probed.scene.set_positions(probed.ids[0], probed.bodies[0].x_t1);
  }
}

TEST(Probes, of_one_scene_keep_answers_of_their_own) {
  ProbedBodies probed({sheet(1)});
  Probe other(probed.scene);
  const Ray down{{0.3, 0.4, 100}, {0, 0, -1}};
  const Ray up{{0.3, 0.4, -100}, {0, 0, 1}};
  const Span<const RayHit> first = probed.probe.first_hits({&down, 1});
  const Span<const RayHit> second = other.first_hits({&up, 1});
  EXPECT_EQ(first[0].t, 99);
  EXPECT_EQ(second[0].t, 101);
}

TEST(Probes, what_is_not_there_is_infinitely_far) {
  ProbedBodies probed({sheet(1)});
  EXPECT_EQ(probed.probe.first_hit({{0.3, 0.4, 100}, {0, 0, 1}}).t, kInfinity);
  EXPECT_EQ(probed.probe.closest_point({{0, 0, 100}, 1.0}).distance, kInfinity);
  EXPECT_EQ(probed.probe.distance({probed.ids[0], BodyId()}).distance, kInfinity);
}

TEST(Probes, answer_about_an_empty_scene_and_to_no_questions) {
  softcd::Scene scene(scene_options());
  Probe probe(scene);
  EXPECT_TRUE(bodies_below(probe).empty());
  EXPECT_FALSE(probe.closest_point({{1, 2, 3}}).has_point());
  EXPECT_TRUE(probe.first_hits({}).empty());
  EXPECT_EQ(probe.all_hits({}).size(), 0U);
  EXPECT_TRUE(probe.closest_points({}).empty());
  const BodyId empty = scene.add_body({{}, 0, {}});
  const Positions3 nowhere;
  scene.set_positions(empty, nowhere);
  EXPECT_TRUE(bodies_below(probe).empty());
}

TEST(Probes, say_what_is_wrong) {
  EXPECT_THAT(error_of([] {
                softcd::Scene scene(scene_options());
                const Probe probe(scene, {static_cast<StepEnd>(7)});
              }),
              HasSubstr("step_end is 7"));
  std::optional<softcd::Scene> scene(std::in_place, scene_options());
  Probe probe(*scene);
  Probe taken(std::move(probe));
  // NOLINTNEXTLINE(bugprone-use-after-move): this is what it says then.
  EXPECT_THAT(error_of([&] { probe.closest_point({}); }), HasSubstr("was moved from"));
  EXPECT_FALSE(taken.closest_point({}).has_point());
  scene.reset();
  EXPECT_THAT(error_of([&] { taken.closest_point({}); }), HasSubstr("the Scene of this Probe is gone"));
  EXPECT_THAT(error_of([&] { taken.set_options({}); }), HasSubstr("the Scene of this Probe is gone"));
}

TEST(Probes, have_positions_read_even_where_they_fail) {
  ProbedBodies probed({sheet(1)});
  {
    const Positions3 higher = sheet(3).x_t1;
    probed.scene.set_positions(probed.ids[0], higher);
    EXPECT_EQ(height_below(probed.probe), 3);
  }
  EXPECT_EQ(height_below(probed.probe), 3);
}

TEST(Probes, keep_to_the_memory_limit) {
  ProbedBodies probed({still(icosphere(3, 1.0), {})});
  SceneOptions options = scene_options();
  options.memory_limit = 1000;
  probed.scene.set_options(options);
  EXPECT_THAT(error_of([&] { probed.probe.closest_point({}); }), HasSubstr("memory ran out for a hierarchy of 1280"));
  options.memory_limit = 0;
  probed.scene.set_options(options);
  EXPECT_NEAR(probed.probe.closest_point({{2, 0, 0}}).distance, 1, 0.01);
}

TEST(Probes, answer_the_same_however_many_threads_there_are) {
  const Mesh mesh = soup_with_everything(4);
  Random random(8);
  std::vector<Ray> rays;
  std::vector<ProbePoint> points;
  for (int i = 0; i < 3000; ++i) {
    rays.push_back({random.in_box(3), random.direction()});
    points.push_back({random.in_box(3), 2});
  }
  std::vector<RayHit> hits;
  std::vector<ClosestPoint> closest;
  for (const std::uint32_t threads : {1U, 4U}) {
    SceneOptions options = scene_options();
    options.max_threads = threads;
    softcd::Scene scene(options);
    const BodyId id = scene.add_body({mesh.triangles, static_cast<std::uint32_t>(mesh.positions.size()), {}});
    scene.set_positions(id, mesh.positions);
    Probe probe(scene);
    const std::vector<RayHit> found_hits = copy_of(probe.all_hits(rays).all());
    const std::vector<ClosestPoint> found_closest = copy_of(probe.closest_points(points));
    if (threads > 1U) {
      ASSERT_EQ(found_hits.size(), hits.size());
      for (std::size_t i = 0; i < hits.size(); ++i) {
        ASSERT_EQ(found_hits[i].t, hits[i].t);
        ASSERT_EQ(found_hits[i].triangle, hits[i].triangle);
      }
      for (std::size_t i = 0; i < closest.size(); ++i) {
        ASSERT_EQ(found_closest[i].distance, closest[i].distance);
        ASSERT_EQ(found_closest[i].triangle, closest[i].triangle);
      }
    }
    hits = found_hits;
    closest = found_closest;
  }
  EXPECT_GT(hits.size(), 1000U);
}

}  // namespace
}  // namespace softcd::test
