#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Mesh soup(std::uint64_t seed, std::uint32_t count = 300) {
  SoupOptions options;
  options.triangle_count = count;
  options.half_extent = 2.0;
  options.size_ratio = 20.0;
  options.joined_share = 0.6;
  options.seed = seed;
  return triangle_soup(options);
}

std::uint64_t triangles_with(const SceneBody& body, const std::vector<std::uint32_t>& vertices) {
  std::uint64_t count = 0;
  for (const Triangle& triangle : body.triangles) {
    for (const std::uint32_t v : vertices) {
      if (triangle.v[0] == v || triangle.v[1] == v || triangle.v[2] == v) {
        ++count;
        break;
      }
    }
  }
  return count;
}

class NonFinite : public testing::TestWithParam<double> {};

// Several triangles share vertices. The features of the remaining triangles must all be found, though left out
// triangles owned some of them.
TEST_P(NonFinite, only_its_triangles_are_left_out) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Scene scene{still(soup(1), everything(0.02F)), still(crumpled_cloth(20, 20, 0.125, 0.05, 2), everything(0.01F))};
    if (detection == Detection::ccd) {
      for (SceneBody& body : scene) {
        body.settings.margin = 0.0F;
        body.x_t0 = jittered(body.x_t1, 0.1, 8);
        snap_to_grid(body.x_t0, 17);
      }
    }
    const std::vector<std::uint32_t> in_soup{3, 40, 41, 200};
    const std::vector<std::uint32_t> in_cloth{0, 21, 22, 137, 399};
    for (const std::uint32_t v : in_soup) scene[0].x_t1[v].y = GetParam();
    for (const std::uint32_t v : in_cloth) scene[1].x_t1[v].z = GetParam();
    if (detection == Detection::ccd) {
      scene[1].x_t0[300].x = GetParam();
    }
    std::vector<std::uint32_t> all_in_cloth = in_cloth;
    if (detection == Detection::ccd) all_in_cloth.push_back(300);

    const PipelineOptions options = test_options(detection);
    if (detection == Detection::dcd) {
      EXPECT_GT(expect_discrete_contacts(scene, options), 100U);
    } else {
      EXPECT_GT(expect_continuous_contacts(scene, options), 100U);
    }

    std::vector<std::string> warnings;
    LoadedScene loaded = load(scene, options, [&](LogLevel level, std::string_view text) {
      if (level == LogLevel::warning) warnings.emplace_back(text);
    });
    loaded.pipeline.detect();
    ASSERT_EQ(warnings.size(), 2U) << "one for each of the bodies";
    EXPECT_THAT(warnings[0], AllOf(HasSubstr("body 0"), HasSubstr("vertex 3")));
    EXPECT_THAT(warnings[1], AllOf(HasSubstr("body 1"), HasSubstr("vertex 0")));
    loaded.pipeline.detect();
    EXPECT_EQ(warnings.size(), 2U) << "said once, not in every detection";
    EXPECT_EQ(loaded.pipeline.query.statistics().left_out_triangles,
              triangles_with(scene[0], in_soup) + triangles_with(scene[1], all_in_cloth));
  }
}

TEST_P(NonFinite, counts_only_where_a_query_looks) {
  const Mesh mesh = soup(5);
  SceneBody body = moving(mesh, jittered(mesh.positions, 0.1, 9), everything(0.02F));
  body.x_t0[3].x = GetParam();
  body.x_t1[40].z = GetParam();
  QueryOptions at_t0, at_t1, on_the_way;
  at_t0.step_end = StepEnd::t0;
  on_the_way.detection = Detection::ccd;

  SceneOptions scene_options;
  scene_options.backend = backend_under_test();
  const auto add_to = [&](softcd::Scene& scene) {
    const BodyId id = scene.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings});
    scene.set_positions(id, body.x_t0, body.x_t1);
  };
  std::vector<std::string> warnings;
  softcd::Scene scene(scene_options, [&](LogLevel level, std::string_view text) {
    if (level == LogLevel::warning) warnings.emplace_back(text);
  });
  add_to(scene);
  Query queries[] = {Query(scene, at_t1), Query(scene, at_t0), Query(scene, on_the_way)};
  const std::vector<std::uint32_t> strays[] = {{40}, {3}, {3, 40}};
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 3; ++i) {
      const Span<const Contact> found = queries[i].detect();
      softcd::Scene alone(scene_options);
      add_to(alone);
      Query only(alone, queries[i].options());
      EXPECT_TRUE(identical(only.detect(), found));
      EXPECT_GT(found.size(), 0U);
      EXPECT_EQ(queries[i].statistics().left_out_triangles, triangles_with(body, strays[i]));
    }
  }
  EXPECT_EQ(warnings.size(), 2U) << "one for each vertex";
}

TEST_P(NonFinite, recovers_when_positions_do) {
  const Scene good{still(soup(2), everything(0.02F))};
  Scene bad = good;
  bad[0].x_t1[7].x = GetParam();
  LoadedScene loaded = load(bad, test_options(Detection::dcd));
  loaded.pipeline.detect();
  loaded.pipeline.scene.set_positions(loaded.ids[0], good[0].x_t0, good[0].x_t1);
  EXPECT_TRUE(identical(detect_once(good, test_options(Detection::dcd)), loaded.pipeline.detect()));
  EXPECT_EQ(loaded.pipeline.query.statistics().left_out_triangles, 0U);
}

TEST_P(NonFinite, every_vertex) {
  Scene scene{still(soup(3), everything(0.02F)), still(soup(4), everything(0.02F))};
  for (Vec3d& p : scene[0].x_t1) p = {GetParam(), GetParam(), GetParam()};
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 0U);
  for (Vec3d& p : scene[1].x_t1) p.z = GetParam();
  EXPECT_TRUE(detect_once(scene, test_options(Detection::dcd)).empty());
}

INSTANTIATE_TEST_SUITE_P(Values, NonFinite, testing::Values(kNaN, kInfinity, -kInfinity));

TEST(SmallInput, empty_pipeline) {
  CollisionPipeline pipeline(test_options(Detection::dcd));
  EXPECT_TRUE(pipeline.detect().empty());
  EXPECT_EQ(pipeline.query.statistics().triangles, 0U);
}

TEST(SmallInput, empty_bodies) {
  CollisionPipeline pipeline(test_options(Detection::ccd));
  const BodyId empty = pipeline.scene.add_body({});
  const BodyId only_vertices = pipeline.scene.add_body({{}, 3, everything(1.0F)});
  pipeline.scene.set_positions(empty, Positions());
  const Positions3 x(3);
  pipeline.scene.set_positions(only_vertices, x, x);
  EXPECT_TRUE(pipeline.detect().empty());
}

TEST(SmallInput, one_triangle) {
  const Mesh triangle{{{{0, 1, 2}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    EXPECT_TRUE(detect_once({still(triangle, everything(10.0F))}, test_options(detection)).empty());
  }
}

TEST(SmallInput, one_point) {
  const Mesh point{{{{0, 0, 0}}}, {{0.5, 0.5, 0.5}}};
  EXPECT_TRUE(detect_once({still(point, everything(1.0F))}, test_options(Detection::dcd)).empty());
  const std::vector<Contact> contacts =
      detect_once({still(point, everything(1.0F)), still(moved(point, {0, 0, 0.25}), everything(0.0F))},
                  test_options(Detection::dcd));
  ASSERT_EQ(contacts.size(), 2U) << "either point against the other as a triangle";
  EXPECT_FLOAT_EQ(contacts[0].distance, 0.25F);
  EXPECT_FLOAT_EQ(contacts[0].normal.z, -1.0F);
  EXPECT_FLOAT_EQ(contacts[1].normal.z, 1.0F);
}

TEST(SmallInput, two_triangles_of_one_body) {
  const Mesh pair{{{{0, 1, 2}}, {{3, 4, 5}}},
                  {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 0.125}, {1.25, 0.25, 1}, {0.25, 1.25, 1}}};
  EXPECT_GT(expect_discrete_contacts({still(pair, everything(0.1F))}, test_options(Detection::dcd)), 0U);
  EXPECT_TRUE(detect_once({still(pair, everything(0.0624F))}, test_options(Detection::dcd)).empty());
}

TEST(SmallInput, two_triangles_that_share_an_edge_fold) {
  const Mesh pair{{{{0, 1, 2}}, {{1, 0, 3}}}, {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0.9375, 0.03125}}};
  EXPECT_GT(expect_discrete_contacts({still(pair, everything(0.05F))}, test_options(Detection::dcd)), 0U);
}

TEST(SmallInput, duplicate_triangles) {
  Mesh mesh = soup(5, 80);
  const std::vector<Triangle> once = mesh.triangles;
  mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
  for (const Triangle& t : once) mesh.triangles.push_back({{t.v[2], t.v[1], t.v[0]}});
  EXPECT_GT(expect_discrete_contacts({still(mesh, everything(0.05F))}, test_options(Detection::dcd)), 0U);
}

TEST(SmallInput, body_without_positions_is_left_out_and_named_once) {
  const Scene scene{still(soup(6), everything(0.02F)), still(soup(7), everything(0.02F))};
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  std::vector<std::string> warnings;
  loaded.pipeline.scene.set_log([&](LogLevel, std::string_view text) { warnings.emplace_back(text); });
  const Mesh waiting = soup(8);
  loaded.pipeline.scene.add_body(
      {waiting.triangles, static_cast<std::uint32_t>(waiting.positions.size()), everything(0.02F)});
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(identical(detect_once(scene, test_options(Detection::dcd)), loaded.pipeline.detect()));
  }
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("body 2 has no positions")));
  const std::vector<StageReport> report = loaded.pipeline.query.explain();
  EXPECT_TRUE(std::any_of(report.begin(), report.end(), [](const StageReport& line) {
    return line.stage == DetectionStage::positions && !line.ran && line.reason.rfind("1 ", 0) == 0;
  }));
}

TEST(SmallInput, continuous_detection_without_an_end_is_named_once) {
  const Mesh mesh = soup(6);
  std::vector<std::string> warnings;
  CollisionPipeline pipeline(test_options(Detection::ccd));
  pipeline.scene.set_log([&](LogLevel, std::string_view text) { warnings.emplace_back(text); });
  EXPECT_TRUE(pipeline.detect().empty()) << "of nothing";
  const BodyDesc desc{mesh.triangles, static_cast<std::uint32_t>(mesh.positions.size()), everything(0.02F)};
  const BodyId id = pipeline.scene.add_body(desc);
  pipeline.scene.set_positions(id, mesh.positions);
  for (int i = 0; i < 2; ++i) pipeline.detect();
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("give set_positions() x_t0 and x_t1")));
}

TEST(SmallInput, vertices_in_no_triangle_do_not_collide) {
  Mesh mesh = soup(9);
  const std::vector<FeaturePair> expected =
      features_of(detect_once({still(mesh, everything(0.02F))}, test_options(Detection::dcd)));
  for (int i = 0; i < 50; ++i) mesh.positions.push_back(mesh.positions[static_cast<std::size_t>(i)]);
  EXPECT_EQ(features_of(detect_once({still(mesh, everything(0.02F))}, test_options(Detection::dcd))), expected);
}

TEST(LargeInput, coincident_triangles) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  }
  BodySettings settings = everything(0.01F);
  settings.features.edge_edge = false;
  const std::vector<Contact> contacts = detect_once({still(mesh, settings)}, test_options(Detection::dcd));
  EXPECT_EQ(contacts.size(), 1000U * 999U * 3U);
  expect_sorted(contacts);
}

TEST(LargeInput, points_in_one_place) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 300; ++i) {
    mesh.triangles.push_back({{i, i, i}});
    mesh.positions.push_back({1, 2, 3});
  }
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    EXPECT_EQ(detect_once({still(mesh, everything(0.01F))}, test_options(detection)).size(), 300U * 299U);
  }
}

// A vertex thrown far away makes one triangle huge. All other contacts must still be found.
TEST(LargeInput, one_vertex_far_away) {
  const Mesh mesh = soup(10, 400);
  const std::vector<FeaturePair> before =
      features_of(detect_once({still(mesh, everything(0.02F))}, test_options(Detection::dcd)));
  for (const double distance : {1e4, 1e8, 1e15, 1e30, 1e38, 1e300}) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      SCOPED_TRACE(testing::Message() << "distance " << distance);
      Mesh thrown = mesh;
      thrown.positions.push_back({distance, 0.5 * distance, -0.25 * distance});
      const auto distant = static_cast<std::uint32_t>(thrown.positions.size() - 1);
      thrown.triangles.push_back({{distant - 2, distant - 1, distant}});
      const std::vector<FeaturePair> after =
          features_of(detect_once({still(thrown, everything(0.02F))}, test_options(detection)));
      std::vector<FeaturePair> lost;
      std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(lost));
      EXPECT_TRUE(lost.empty()) << lost.size() << " of " << before.size() << " contacts lost";
    }
  }
}

TEST(LargeInput, margin_larger_than_the_scene_pairs_everything) {
  const Mesh mesh = soup(11, 40);
  Scene scene{still(mesh, everything(100.0F))};
  expect_discrete_contacts(scene, test_options(Detection::dcd));
}

}  // namespace
}  // namespace softcd::test
