#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

// explain() says that unnecessary work is skipped, and the contacts are the same as with that work.
namespace softcd::test {
namespace {

bool ran(const Outcome& outcome, DetectionStage stage) {
  const auto line = std::find_if(outcome.report.begin(), outcome.report.end(),
                                 [&](const StageReport& entry) { return entry.stage == stage; });
  EXPECT_NE(line, outcome.report.end()) << "no line about " << name_of(stage);
  return line != outcome.report.end() && line->ran;
}

Mesh coarse_soup(std::uint64_t seed, std::uint32_t triangle_count = 400) {
  SoupOptions options;
  options.triangle_count = triangle_count;
  options.half_extent = 2.0;
  options.joined_share = 0.5;
  options.grid_bits = 4;  // coarse, so that many features touch exactly
  options.seed = seed;
  return triangle_soup(options);
}

/// Two bodies that touch themselves and each other.
Scene two_soups(float margin = 0.02F) {
  return {still(coarse_soup(1), everything(margin)), still(coarse_soup(2), everything(margin))};
}

/// The scene with a triangle that touches nothing and moves.
Scene with_a_mover(Scene scene) {
  const Mesh away{{{{0, 1, 2}}}, {{50, 0, 0}, {51, 0, 0}, {50, 1, 0}}};
  scene.push_back(moving(away, {{50, 0, 1}, {51, 0, 1}, {50, 1, 1}}, everything()));
  return scene;
}

std::vector<Contact> of_kind(const std::vector<Contact>& contacts, ContactKind kind) {
  std::vector<Contact> kept;
  std::copy_if(contacts.begin(), contacts.end(), std::back_inserter(kept),
               [&](const Contact& contact) { return contact.kind == kind; });
  return kept;
}

std::vector<Contact> between_bodies(const std::vector<Contact>& contacts) {
  std::vector<Contact> kept;
  std::copy_if(contacts.begin(), contacts.end(), std::back_inserter(kept),
               [](const Contact& contact) { return !(contact.body_a == contact.body_b); });
  return kept;
}

/// Returns the contacts of a scene in double, or of the same scene in float.
std::vector<Contact> contacts_of(const Scene& scene, const PipelineOptions& options, bool in_double) {
  LoadedScene loaded = load(scene, options);
  std::vector<std::vector<Vec3f>> floats;
  for (const SceneBody& body : scene) {
    for (const Positions3* x : {&body.x_t0, &body.x_t1}) {
      floats.emplace_back();
      for (const Vec3d& p : *x) floats.back().push_back(vec3_cast<float>(p));
    }
  }
  for (std::size_t b = 0; b < scene.size() && !in_double; ++b) {
    loaded.pipeline.scene.set_positions(loaded.ids[b], floats[2 * b], floats[2 * b + 1]);
  }
  const Span<const Contact> contacts = loaded.pipeline.detect();
  const std::vector<StageReport> report = loaded.pipeline.query.explain();
  const auto is_chosen = [&](const StageReport& line) {
    const char* const name = options.accuracy == Accuracy::conservative ? "conservative: " : "precise: ";
    return line.stage == DetectionStage::accuracy && line.reason.rfind(name, 0) == 0;
  };
  EXPECT_TRUE(options.accuracy == Accuracy::automatic || std::any_of(report.begin(), report.end(), is_chosen));
  return {contacts.begin(), contacts.end()};
}

TEST(AutomaticAccuracy, is_conservative_for_doubles_and_on_the_way_with_margins) {
  for (const float margin : {0.0F, 0.02F}) {
    Scene scene = two_soups(margin);
    for (SceneBody& body : scene) {
      for (Vec3d& p : body.x_t0) p = p + Vec3d{1.0 / 3.0, 1.0 / 7.0, 1.0 / 9.0};
      body.x_t1 = jittered(body.x_t0, 0.1, 5);
    }
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      for (const bool in_double : {true, false}) {
        const bool is_conservative = in_double || (detection == Detection::ccd && margin > 0.0F);
        PipelineOptions options = test_options(detection);
        options.accuracy = is_conservative ? Accuracy::conservative : Accuracy::precise;
        const std::vector<Contact> expected = contacts_of(scene, options, in_double);
        ASSERT_TRUE(!expected.empty() || (detection == Detection::dcd && margin == 0.0F));
        options.accuracy = QueryOptions().accuracy;
        EXPECT_TRUE(identical(contacts_of(scene, options, in_double), expected)) << margin << " " << in_double;
      }
    }
  }
}

TEST(AutomaticAccuracy, is_precise_on_the_way_without_margins_that_count) {
  Scene scene = two_soups(0.02F);
  for (SceneBody& body : scene) body.x_t1 = jittered(body.x_t0, 0.1, 5);
  PipelineOptions options = test_options(Detection::ccd);
  options.margins = false;
  const std::vector<Contact> expected = contacts_of(scene, options, /*in_double=*/false);
  options.accuracy = Accuracy::automatic;
  EXPECT_TRUE(identical(contacts_of(scene, options, /*in_double=*/false), expected));
}

TEST(Defaults, find_all_contacts_of_one_mesh_with_itself) {
  const Mesh soup = coarse_soup(7);
  CollisionPipeline pipeline;
  const BodyId body = pipeline.scene.add_body({soup.triangles, static_cast<std::uint32_t>(soup.positions.size()), {}});
  pipeline.scene.set_positions(body, soup.positions);
  const Span<const Contact> contacts = pipeline.detect();
  PipelineOptions options = test_options(Detection::dcd);
  options.accuracy = Accuracy::conservative;
  EXPECT_EQ(features_of(contacts), features_of(detect_once({still(soup, everything())}, options)));
  EXPECT_FALSE(of_kind({contacts.begin(), contacts.end()}, ContactKind::edge_edge).empty());
}

class AutomaticChoices : public testing::TestWithParam<Accuracy> {};

TEST_P(AutomaticChoices, nothing_is_swept_where_nothing_moves) {
  for (const float margin : {0.0F, 0.02F}) {
    PipelineOptions options = test_options(Detection::ccd);
    options.accuracy = GetParam();
    const Outcome at_rest = outcome_of(two_soups(margin), options);
    const Outcome swept = outcome_of(with_a_mover(two_soups(margin)), options);
    EXPECT_FALSE(at_rest.contacts.empty());
    EXPECT_TRUE(identical(at_rest.contacts, swept.contacts));
    EXPECT_FALSE(ran(at_rest, DetectionStage::swept_volumes));
    EXPECT_TRUE(ran(swept, DetectionStage::swept_volumes));
    EXPECT_LT(at_rest.statistics.peak_bytes, swept.statistics.peak_bytes) << "volumes of the step's ends are kept";

    options.detection = Detection::dcd;
    const Outcome discrete = outcome_of(two_soups(margin), options);
    EXPECT_EQ(at_rest.statistics.triangle_pairs, discrete.statistics.triangle_pairs);
    EXPECT_EQ(at_rest.statistics.vt_candidates, discrete.statistics.vt_candidates);
    EXPECT_EQ(at_rest.statistics.ee_candidates, discrete.statistics.ee_candidates);
  }
}

INSTANTIATE_TEST_SUITE_P(Accuracies, AutomaticChoices,
                         testing::Values(Accuracy::fast, Accuracy::precise, Accuracy::conservative),
                         [](const auto& test) {
                           return test.param == Accuracy::fast      ? "fast"
                                  : test.param == Accuracy::precise ? "precise"
                                                                    : "conservative";
                         });

TEST(AutomaticChoices, a_body_that_starts_or_stops_moving_is_noticed) {
  const Scene at_rest = two_soups(0.0F);
  Scene moves = at_rest;
  moves[1].x_t0 = translated(moves[1].x_t1, {0.0, 0.0, 0.25});
  const PipelineOptions options = test_options(Detection::ccd);
  ASSERT_FALSE(identical(detect_once(at_rest, options), detect_once(moves, options)));
  LoadedScene loaded = load(at_rest, options);
  for (const Scene& scene : {at_rest, moves, at_rest, moves}) {
    for (std::size_t b = 0; b < scene.size(); ++b)
      loaded.pipeline.scene.set_positions(loaded.ids[b], scene[b].x_t0, scene[b].x_t1);
    EXPECT_TRUE(identical(loaded.pipeline.detect(), detect_once(scene, options)));
  }
}

TEST(AutomaticChoices, no_edges_without_a_consumer) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Scene scene = two_soups();
    const Outcome both = outcome_of(scene, test_options(detection));
    scene[0].settings.features.edge_edge = false;
    scene[1].settings.features.edge_edge = false;
    const Outcome vertices = outcome_of(scene, test_options(detection));
    EXPECT_TRUE(identical(vertices.contacts, of_kind(both.contacts, ContactKind::vertex_triangle)));
    EXPECT_FALSE(vertices.contacts.empty());
    EXPECT_EQ(vertices.statistics.ee_candidates, 0U);
    EXPECT_GT(both.statistics.ee_candidates, 0U);
    EXPECT_FALSE(ran(vertices, DetectionStage::edge_edge_tests));
  }
}

TEST(AutomaticChoices, no_edges_where_only_one_side_wants_them) {
  Scene scene = two_soups();
  for (SceneBody& body : scene) body.settings.self_collision = false;
  scene[1].settings.features.edge_edge = false;
  const Outcome outcome = outcome_of(scene, test_options(Detection::dcd));
  EXPECT_FALSE(outcome.contacts.empty());
  EXPECT_EQ(outcome.statistics.ee_candidates, 0U);
  EXPECT_FALSE(ran(outcome, DetectionStage::edge_edge_tests));
}

TEST(AutomaticChoices, no_pairs_within_bodies_without_self_collision) {
  Scene scene = two_soups();
  const Outcome with_self = outcome_of(scene, test_options(Detection::dcd));
  for (SceneBody& body : scene) body.settings.self_collision = false;
  const Outcome without = outcome_of(scene, test_options(Detection::dcd));
  EXPECT_TRUE(identical(without.contacts, between_bodies(with_self.contacts)));
  EXPECT_LT(without.contacts.size(), with_self.contacts.size());
  EXPECT_LT(without.statistics.triangle_pairs, with_self.statistics.triangle_pairs);

  const Outcome alone = outcome_of({scene[0]}, test_options(Detection::dcd));
  EXPECT_FALSE(ran(alone, DetectionStage::broad_phase));
  EXPECT_EQ(alone.statistics.entries, 0U);
  EXPECT_EQ(alone.statistics.peak_bytes, 0U) << "something was computed";
}

TEST(AutomaticChoices, static_bodies_are_never_compared) {
  Scene scene = two_soups();
  for (SceneBody& body : scene) body.settings.kinematic = true;
  const Outcome only_static = outcome_of(scene, test_options(Detection::dcd));
  EXPECT_FALSE(ran(only_static, DetectionStage::broad_phase));
  EXPECT_EQ(only_static.statistics.entries, 0U);
  EXPECT_TRUE(only_static.contacts.empty());

  const SceneBody dynamic = still(coarse_soup(3), everything(0.02F));
  const Outcome with_dynamic = outcome_of({scene[0], scene[1], dynamic}, test_options(Detection::dcd));
  const auto pair_filter = [](BodyId a, BodyId b) { return !(a == BodyId{0} && b == BodyId{1}); };
  for (SceneBody& body : scene) {
    body.settings.kinematic = false;
    body.settings.self_collision = false;
  }
  EXPECT_TRUE(identical(with_dynamic.contacts,
                        detect_once({scene[0], scene[1], dynamic}, test_options(Detection::dcd), pair_filter)));
  EXPECT_FALSE(with_dynamic.contacts.empty());
}

Scene two_balls() {
  const Mesh ball = icosphere(4, 1.0);
  return {still(ball, everything(0.01F)), still(moved(ball, {1.5, 0.25, 0.125}), everything(0.01F))};
}

TEST(AutomaticChoices, triangles_of_one_size_are_not_split) {
  const Scene even = two_balls();
  Scene uneven = even;
  uneven.push_back(still(Mesh{{{{0, 1, 2}}}, {{0, 0, 0.75}, {1.4, 0, 0.75}, {0, 1.4, 0.75}}}, everything(0.01F)));
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    for (const Scene& scene : {even, uneven}) {
      PipelineOptions options = test_options(detection);
      const Outcome outcome = outcome_of(scene, options);
      EXPECT_EQ(ran(outcome, DetectionStage::virtual_subdivision), scene.size() == 3);
      EXPECT_EQ(outcome.statistics.children > 0, scene.size() == 3);
      options.subdivision = false;
      EXPECT_TRUE(identical(outcome.contacts, outcome_of(scene, options).contacts));
      EXPECT_FALSE(outcome.contacts.empty());
    }
  }
}

TEST(AutomaticChoices, a_triangle_is_not_split_where_tests_against_all_cost_less) {
  Scene scene = two_balls();
  for (const double side : {1.4, 8.0}) {
    const Mesh triangle{{{{0, 1, 2}}}, {{0, 0, 0.75}, {side, 0, 0.75}, {0, side, 0.75}}};
    scene.push_back(still(triangle, everything(0.01F)));
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      PipelineOptions options = test_options(detection);
      const Outcome outcome = outcome_of(scene, options);
      EXPECT_EQ(outcome.statistics.split_triangles, 1U);
      EXPECT_EQ(outcome.statistics.big_triangles, scene.size() - 3);
      EXPECT_EQ(ran(outcome, DetectionStage::tests_against_all), scene.size() == 4);
      options.broad_phase = BroadPhase::uniform;
      EXPECT_TRUE(identical(outcome.contacts, outcome_of(scene, options).contacts));
      EXPECT_FALSE(outcome.contacts.empty());
    }
  }
}

TEST(AutomaticChoices, small_scenes_stay_on_the_cpu) {
  PipelineOptions options = test_options(Detection::ccd);
  const Scene little{still(coarse_soup(4, 60), everything(0.1F)), still(coarse_soup(5, 60), everything(0.1F))};
  const Outcome expected = outcome_of(little, options);
  EXPECT_FALSE(expected.contacts.empty());
  options.backend = Backend::automatic;
  const Outcome automatic = outcome_of(little, options);
  EXPECT_EQ(automatic.statistics.backend, Backend::cpu);
  EXPECT_EQ(automatic.report.front().stage, DetectionStage::backend);
  EXPECT_EQ(automatic.report.front().reason.rfind("cpu: ", 0), 0U) << automatic.report.front().reason;
  EXPECT_TRUE(identical(automatic.contacts, expected.contacts));
}

}  // namespace
}  // namespace softcd::test
