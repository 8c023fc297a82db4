#include <gtest/gtest.h>

#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "rank_scene.hpp"
#include "scene.hpp"

// Many small scenes in one: bodies of different batches never touch, though they are at the same place.
namespace softcd::test {
namespace {

SceneBody soup_body(std::uint32_t triangles, double largest, std::uint64_t seed, std::uint32_t batch) {
  SoupOptions options;
  options.triangle_count = triangles;
  options.half_extent = 1.0;
  options.largest = largest;
  options.size_ratio = 6.0;
  options.joined_share = 0.4;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  SceneBody body = moving(mesh, scattered(mesh, 0.2, seed + 100), everything(0.02F));
  body.settings.batch = batch;
  return body;
}

/// Two or three bodies a batch, some with large triangles; numbers of batches are far apart.
Scene batches_of_soups(std::uint32_t count) {
  Scene scene;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t batch = i * i * 1000003U;
    scene.push_back(soup_body(60, 0.3, 3 * i + 1, batch));
    scene.push_back(soup_body(60, 0.3, 3 * i + 2, batch));
    if (i % 3 == 0) scene.push_back(soup_body(4, 4.0, 3 * i + 3, batch));
  }
  return scene;
}

/// Moves the bodies into one batch, and returns a filter that separates what batches separated.
PairFilter as_filter(Scene& scene) {
  std::vector<std::uint32_t> batches;
  for (SceneBody& body : scene) batches.push_back(std::exchange(body.settings.batch, 0U));
  return [batches](BodyId a, BodyId b) { return batches[a.value] == batches[b.value]; };
}

TEST(Batches, find_what_each_would_alone) {
  for (const std::uint32_t count : {3U, 40U}) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      for (const Accuracy accuracy : {Accuracy::fast, Accuracy::conservative}) {
        PipelineOptions options = test_options(detection);
        options.accuracy = accuracy;
        const Scene scene = batches_of_soups(count);
        Scene filtered = scene;
        const PairFilter filter = as_filter(filtered);
        const std::vector<Contact> expected = detect_once(filtered, options, filter);
        EXPECT_GT(expected.size(), 100U * count);
        EXPECT_TRUE(identical(expected, detect_once(scene, options)));
      }
    }
  }
}

TEST(Batches, do_not_meet_in_cells) {
  const auto tests_of = [](std::uint32_t copies) {
    Scene scene;
    for (std::uint32_t batch = 0; batch < copies; ++batch) {
      scene.push_back(soup_body(200, 0.2, 1, batch));
      scene.push_back(soup_body(200, 0.2, 2, batch));
    }
    return outcome_of(scene, test_options(Detection::dcd)).statistics.tests;
  };
  const std::uint64_t alone = tests_of(1);
  EXPECT_LT(tests_of(64), 70 * alone);
}

TEST(Batches, may_be_shared_out_to_ranks) {
  const Scene scene = batches_of_soups(20);
  const PipelineOptions options = test_options(Detection::ccd);
  const std::vector<Contact> expected = detect_once(scene, options);
  expect_no_problem(in_ranks(Communicator::of_threads(3), [&](const Communicator& communicator) {
    RankScene rank(scene, communicator, options);
    rank.set_positions(scene);
    const std::size_t own = rank.query().detect().size();
    EXPECT_GT(own, 0U);
    EXPECT_LT(own, expected.size());
    EXPECT_TRUE(identical(expected, rank.query().gather_contacts()));
  }));
}

TEST(Batches, of_bodies_may_change) {
  Scene scene{soup_body(60, 0.3, 1, 1), soup_body(60, 0.3, 2, 2)};
  for (SceneBody& body : scene) body.settings.self_collision = false;
  LoadedScene loaded = load(scene, test_options(Detection::ccd));
  EXPECT_TRUE(loaded.pipeline.detect().empty());
  scene[1].settings.batch = 1;
  loaded.pipeline.scene.set_settings(loaded.ids[1], scene[1].settings);
  EXPECT_FALSE(loaded.pipeline.detect().empty());
}

}  // namespace
}  // namespace softcd::test
