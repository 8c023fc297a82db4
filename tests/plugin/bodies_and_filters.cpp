#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

Mesh small_soup(std::uint64_t seed, std::uint32_t count = 150) {
  SoupOptions options;
  options.triangle_count = count;
  options.half_extent = 1.5;
  options.size_ratio = 10.0;
  options.seed = seed;
  return triangle_soup(options);
}

Scene soups(std::uint32_t body_count) {
  Scene scene;
  for (std::uint32_t i = 0; i < body_count; ++i) scene.push_back(still(small_soup(40 + i), everything(0.02F)));
  return scene;
}

void expect_both_kinds(const Scene& scene, const PairFilter& pair_filter = {}) {
  PipelineOptions options = test_options(Detection::dcd);
  DiscreteRules rules;
  rules.pair_filter = pair_filter;
  expect_discrete_contacts(scene, options, rules);
  Scene moving_scene = scene;
  for (SceneBody& body : moving_scene) {
    body.settings.margin = 0.0F;
    body.x_t0 = jittered(body.x_t1, 0.1, 5);
    snap_to_grid(body.x_t0, 17);
  }
  options.detection = Detection::ccd;
  expect_continuous_contacts(moving_scene, options, pair_filter);
}

std::set<std::pair<std::uint32_t, std::uint32_t>> body_pairs(const std::vector<Contact>& contacts) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Contact& contact : contacts) pairs.insert(std::minmax(contact.body_a.value, contact.body_b.value));
  return pairs;
}

TEST(Filters, groups_and_masks) {
  Scene scene = soups(5);
  const std::uint32_t groups[] = {1, 2, 4, 0x80000000U, 3};
  const std::uint32_t masks[] = {0xFFFFFFFFU, 1, 1 | 4, 0xFFFFFFFFU, 0};
  for (std::size_t i = 0; i < scene.size(); ++i) {
    scene[i].settings.filter_group = groups[i];
    scene[i].settings.filter_mask = masks[i];
    scene[i].settings.self_collision = i == 4;
  }
  expect_both_kinds(scene);
  EXPECT_EQ(body_pairs(detect_once(scene, test_options(Detection::dcd))),
            (std::set<std::pair<std::uint32_t, std::uint32_t>>{{0, 1}, {0, 2}, {0, 3}, {4, 4}}));
}

TEST(Filters, kinematic_bodies_do_not_meet) {
  Scene scene = soups(4);
  for (SceneBody& body : scene) body.settings.self_collision = false;
  scene[1].settings.kinematic = scene[3].settings.kinematic = true;
  expect_both_kinds(scene);
  EXPECT_FALSE(body_pairs(detect_once(scene, test_options(Detection::dcd))).contains({1, 3}));
}

TEST(Filters, self_collision_only_where_wanted) {
  Scene scene = soups(3);
  scene[1].settings.self_collision = false;
  expect_both_kinds(scene);
}

TEST(Filters, features_that_both_want) {
  Scene scene = soups(4);
  scene[0].settings.features = {true, false};
  scene[1].settings.features = {false, true};
  scene[2].settings.features = {false, false};
  expect_both_kinds(scene);
}

TEST(Filters, pair_filter) {
  expect_both_kinds(soups(4), [](BodyId a, BodyId b) { return (a.value + b.value) % 2 == 1; });
}

// A body that collides with itself is a pair, too.
TEST(Filters, pair_filter_is_asked_about_a_body_and_itself) {
  expect_both_kinds(soups(3), [](BodyId a, BodyId b) { return a != b || a.value == 1; });
}

// The grid then orders a cell's entries by body modulo 8, and tells bodies apart by class modulo 32.
TEST(Filters, without_self_collision_whatever_the_number_of_bodies) {
  for (const std::uint32_t count : {2U, 8U, 9U, 34U}) {
    Scene scene;
    for (std::uint32_t i = 0; i < count; ++i) {
      scene.push_back(still(small_soup(90 + i, 200 / count), everything(0.02F)));
      scene.back().settings.self_collision = false;
    }
    expect_both_kinds(scene);
    expect_both_kinds(scene, [](BodyId a, BodyId b) { return (a.value ^ b.value) % 3 != 1; });
  }
}

TEST(Filters, pair_filter_is_asked_in_ascending_order) {
  Scene scene = soups(4);
  scene[2].settings.filter_mask = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> asked;
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  loaded.pipeline.query.set_pair_filter([&](BodyId a, BodyId b) {
    asked.emplace_back(a.value, b.value);
    return false;
  });
  loaded.pipeline.detect();
  EXPECT_TRUE(std::is_sorted(asked.begin(), asked.end()));
  for (const auto& [a, b] : asked) EXPECT_TRUE(a < b || (a == b && scene[a].settings.self_collision));
  EXPECT_THAT(asked,
              testing::IsSupersetOf({std::pair(0U, 0U), std::pair(0U, 1U), std::pair(0U, 3U), std::pair(1U, 3U)}));
  for (const auto& [a, b] : asked) EXPECT_TRUE(a == b || (a != 2 && b != 2));
}

TEST(Bodies, all_off) {
  Scene scene = soups(2);
  for (SceneBody& body : scene) {
    body.settings.self_collision = false;
    body.settings.filter_mask = 0;
  }
  EXPECT_TRUE(detect_once(scene, test_options(Detection::dcd)).empty());
}

TEST(Bodies, added_and_removed_between_detections) {
  const Scene scene = soups(5);
  LoadedScene loaded = load({scene[0], scene[1]}, test_options(Detection::dcd));
  const auto contacts = [&] {
    const Span<const Contact> found = loaded.pipeline.detect();
    return std::vector<Contact>(found.begin(), found.end());
  };
  EXPECT_EQ(features_of(contacts()), features_of(detect_once({scene[0], scene[1]}, test_options(Detection::dcd))));

  const auto add = [&](const SceneBody& body) {
    const BodyId id =
        loaded.pipeline.scene.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings});
    loaded.pipeline.scene.set_positions(id, body.x_t0, body.x_t1);
    return id;
  };
  const BodyId third = add(scene[2]);
  EXPECT_EQ(features_of(contacts()),
            features_of(detect_once({scene[0], scene[1], scene[2]}, test_options(Detection::dcd))));

  loaded.pipeline.scene.remove_body(loaded.ids[0]);
  const BodyId fourth = add(scene[3]);
  EXPECT_NE(fourth, loaded.ids[0]) << "ids are not reused";
  std::vector<Contact> found = contacts();
  const Scene left{scene[1], scene[2], scene[3]};
  const std::vector<BodyId> ids{loaded.ids[1], third, fourth};
  for (Contact& contact : found) {
    for (BodyId* id : {&contact.body_a, &contact.body_b}) {
      id->value = static_cast<std::uint32_t>(std::find(ids.begin(), ids.end(), *id) - ids.begin());
    }
  }
  EXPECT_EQ(features_of(found), features_of(detect_once(left, test_options(Detection::dcd))));
}

TEST(Bodies, new_topology) {
  Scene scene = soups(2);
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  loaded.pipeline.detect();
  scene[0] = still(small_soup(99, 60), everything(0.05F));
  loaded.pipeline.scene.update_body(
      loaded.ids[0], {scene[0].triangles, static_cast<std::uint32_t>(scene[0].x_t1.size()), scene[0].settings});
  loaded.pipeline.scene.set_positions(loaded.ids[0], scene[0].x_t0, scene[0].x_t1);
  EXPECT_TRUE(identical(detect_once(scene, test_options(Detection::dcd)), loaded.pipeline.detect()));
}

TEST(Bodies, same_vertices_other_triangles) {
  Scene scene = soups(2);
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  loaded.pipeline.detect();
  scene[0].triangles.resize(scene[0].triangles.size() / 2);
  loaded.pipeline.scene.update_body(
      loaded.ids[0], {scene[0].triangles, static_cast<std::uint32_t>(scene[0].x_t1.size()), scene[0].settings});
  loaded.pipeline.scene.set_positions(loaded.ids[0], scene[0].x_t0, scene[0].x_t1);
  EXPECT_TRUE(identical(detect_once(scene, test_options(Detection::dcd)), loaded.pipeline.detect()));
}

TEST(Bodies, new_settings) {
  Scene scene = soups(2);
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  loaded.pipeline.detect();
  scene[1].settings.margin = 0.1F;
  scene[1].settings.self_collision = false;
  scene[0].settings.features.edge_edge = false;
  for (std::size_t i = 0; i < scene.size(); ++i) loaded.pipeline.scene.set_settings(loaded.ids[i], scene[i].settings);
  EXPECT_TRUE(identical(detect_once(scene, test_options(Detection::dcd)), loaded.pipeline.detect()));
}

TEST(Bodies, new_positions_every_frame) {
  Scene scene = soups(2);
  LoadedScene loaded = load(scene, test_options(Detection::ccd));
  for (std::uint64_t frame = 0; frame < 6; ++frame) {
    for (std::size_t i = 0; i < scene.size(); ++i) {
      scene[i].x_t0 = scene[i].x_t1;
      scene[i].x_t1 = jittered(scene[i].x_t0, 0.2, 10 * frame + i);
      loaded.pipeline.scene.set_positions(loaded.ids[i], scene[i].x_t0, scene[i].x_t1);
    }
    EXPECT_TRUE(identical(detect_once(scene, test_options(Detection::ccd)), loaded.pipeline.detect()));
  }
}

TEST(Bodies, new_options) {
  const Scene scene = soups(2);
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  for (const BroadPhase broad_phase : {BroadPhase::uniform, BroadPhase::exact}) {
    for (const Detection detection : {Detection::ccd, Detection::dcd}) {
      const PipelineOptions options = test_options(detection, broad_phase);
      loaded.pipeline.set_options(options);
      EXPECT_EQ(loaded.pipeline.options().broad_phase, broad_phase);
      EXPECT_TRUE(identical(detect_once(scene, options), loaded.pipeline.detect()));
    }
  }
}

TEST(Bodies, moved_pipeline_keeps_its_bodies) {
  const Scene scene = soups(2);
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  CollisionPipeline other(std::move(loaded.pipeline));
  EXPECT_TRUE(identical(detect_once(scene, test_options(Detection::dcd)), other.detect()));
}

TEST(Bodies, many_small_ones) {
  Scene scene;
  for (std::uint32_t i = 0; i < 300; ++i) {
    SoupOptions one;
    one.triangle_count = 1 + i % 3;
    one.half_extent = 2.0;
    one.seed = 1000 + i;
    scene.push_back(still(triangle_soup(one), everything(0.02F)));
  }
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 100U);
}

/// Returns a square of `side`^2 single triangles, each of which touches the ones before and behind it.
Scene triangles_in_rows(std::uint32_t side) {
  Scene scene;
  const Mesh triangle{{{{0, 1, 2}}}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}};
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t place = 0; place < side; ++place) {
      scene.push_back(still(moved(triangle, {2.0 * row, 0.0, 0.9 * place}), BodySettings{}));
      scene.back().settings.margin = 0.001F;
    }
  }
  return scene;
}

TEST(Bodies, cost_memory_in_proportion_to_their_number) {
  const Outcome few = outcome_of(triangles_in_rows(80), test_options(Detection::dcd));
  const Outcome many = outcome_of(triangles_in_rows(160), test_options(Detection::dcd));
  ASSERT_GT(few.contacts.size(), 6000U);
  EXPECT_EQ(many.contacts.size() * 80 * 79, few.contacts.size() * 160 * 159);
  EXPECT_LT(10 * many.statistics.peak_bytes, 41 * few.statistics.peak_bytes);
}

TEST(Bodies, removed_many_at_a_time) {
  const Scene scene = triangles_in_rows(30);
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  Scene left;
  for (std::size_t i = 0; i < loaded.ids.size(); ++i) {
    if (i % 5 == 0) {
      left.push_back(scene[i]);
      continue;
    }
    loaded.pipeline.scene.remove_body(loaded.ids[i]);
    EXPECT_THROW(loaded.pipeline.scene.remove_body(loaded.ids[i]), InvalidInput);
    EXPECT_THROW(loaded.pipeline.scene.set_settings(loaded.ids[i], {}), InvalidInput);
  }
  const BodyId last =
      loaded.pipeline.scene.add_body({scene[1].triangles, static_cast<std::uint32_t>(scene[1].x_t1.size()), {}});
  EXPECT_EQ(last.value, scene.size());
  loaded.pipeline.scene.remove_body(last);
  EXPECT_EQ(loaded.pipeline.detect().size(), detect_once(left, test_options(Detection::dcd)).size());
  EXPECT_EQ(loaded.pipeline.query.statistics().bodies, left.size());
}

}  // namespace
}  // namespace softcd::test
