#include <gtest/gtest.h>

#include <vector>

#include "mesh_generators.hpp"
#include "scene.hpp"

// On the CPU scenes of few triangles are swept along an axis, and have the same contacts as in the grid.
namespace softcd::test {
namespace {

/// Returns options that ask for cells and therefore use the grid.
PipelineOptions in_the_grid(PipelineOptions options) {
  options.cell_size_factor = 1.8F;
  return options;
}

bool is_swept(const Statistics& statistics) {
  return statistics.cell_size == 0 && statistics.entries == statistics.active_triangles && statistics.entries > 0;
}

Scene crumpled(std::uint32_t columns, std::uint32_t rows) {
  const Mesh cloth = crumpled_cloth(columns, rows, 0.1, 0.08, 3);
  const Mesh ball = moved(icosphere(2, 0.7), {1, 0.5, 0.4});
  BodySettings alone = everything(0.02F);
  alone.self_collision = false;
  return {moving(cloth, translated(cloth.positions, {0.2, 0.1, -0.3}), everything(0.01F)),
          moving(ball, jittered(ball.positions, 0.05, 4), alone)};
}

class SweptScenes : public testing::TestWithParam<Detection> {
 protected:
  void SetUp() override {
    if (backend_under_test() != Backend::cpu) GTEST_SKIP() << "elsewhere all scenes are in the grid";
  }
};

TEST_P(SweptScenes, have_the_contacts_of_the_grid) {
  const Scene scene = crumpled(30, 20);
  for (const Accuracy accuracy : {Accuracy::fast, Accuracy::precise, Accuracy::conservative}) {
    PipelineOptions options = test_options(GetParam());
    options.accuracy = accuracy;
    const Outcome swept = outcome_of(scene, options);
    const Outcome grid = outcome_of(scene, in_the_grid(options));
    EXPECT_TRUE(is_swept(swept.statistics));
    EXPECT_FALSE(is_swept(grid.statistics));
    EXPECT_GT(swept.contacts.size(), 100U);
    EXPECT_TRUE(identical(swept.contacts, grid.contacts));
  }
}

TEST_P(SweptScenes, that_move_on_have_the_contacts_of_the_grid) {
  const Scene scene = crumpled(20, 20);
  LoadedScene swept = load(scene, test_options(GetParam()));
  LoadedScene grid = load(scene, in_the_grid(test_options(GetParam())));
  bool has_reused = false;
  for (int step = 0; step < 40; ++step) {
    for (std::size_t b = 0; b < scene.size(); ++b) {
      const Vec3d motion = {0.0, 0.0, (b == 0 ? -2e-4 : 1e-4) * (step % 20)};
      for (LoadedScene* loaded : {&swept, &grid}) {
        SceneBody& body = loaded->scene[b];
        body.x_t0 = body.x_t1;
        body.x_t1 = translated(body.x_t1, motion);
        loaded->pipeline.scene.set_positions(loaded->ids[b], body.x_t0, body.x_t1);
      }
    }
    EXPECT_TRUE(identical(swept.pipeline.detect(), grid.pipeline.detect())) << step;
    has_reused |= swept.pipeline.query.statistics().reused_pairs;
  }
  EXPECT_TRUE(has_reused);
}

TEST_P(SweptScenes, are_those_of_few_triangles) {
  EXPECT_TRUE(is_swept(outcome_of(crumpled(40, 40), test_options(GetParam())).statistics));
  EXPECT_FALSE(is_swept(outcome_of(crumpled(60, 60), test_options(GetParam())).statistics));
}

// Strips side by side cover the whole sweep, whichever axis it takes.
TEST_P(SweptScenes, are_not_those_where_everything_begins_before_anything_ends) {
  Mesh strips;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const double x = 0.008 * i;
    const auto first = static_cast<std::uint32_t>(strips.positions.size());
    strips.positions.insert(strips.positions.end(), {{x, x, 0}, {x + 9, x - 9, 9}, {x, x, 0.001}});
    strips.triangles.push_back({{first, first + 1, first + 2}});
  }
  const Scene scene = {still(strips, everything(0.0001F))};
  const Outcome outcome = outcome_of(scene, test_options(GetParam()));
  EXPECT_FALSE(is_swept(outcome.statistics));
  EXPECT_TRUE(identical(outcome.contacts, detect_once(scene, in_the_grid(test_options(GetParam())))));
}

INSTANTIATE_TEST_SUITE_P(Detections, SweptScenes, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

}  // namespace
}  // namespace softcd::test
