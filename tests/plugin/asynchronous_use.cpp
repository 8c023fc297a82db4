#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

// Calls that the caller may make between Query::start() and Ticket::wait().
namespace softcd::test {
namespace {

using testing::HasSubstr;

/// Two sheets, the upper one above the lower.
Scene two_sheets(std::uint32_t side = 6) {
  BodySettings settings = everything(0.05F);
  settings.self_collision = false;
  const Mesh sheet = grid_cloth(side, side, 0.25);
  return {still(sheet, settings),
          moving(moved(sheet, {0.1, 0.1, 0.08}), translated(sheet.positions, {0.1, 0.1, 0.04}), settings)};
}

/// Returns the upper sheet's positions at the end of step `step`.
Positions3 end_of_step(const Scene& scene, int step) {
  return translated(scene[1].x_t1, {0.0, 0.001 * (step % 97), 0.06 * std::sin(0.1 * step)});
}

class AsynchronousUse : public testing::TestWithParam<Detection> {
 protected:
  std::vector<Contact> fresh(const Scene& scene) const { return detect_once(scene, test_options(GetParam())); }
};

TEST_P(AsynchronousUse, a_streaming_loop_has_the_contacts_of_a_plain_one) {
  constexpr int kSteps = 1000;
  LoadedScene plain = load(two_sheets(), test_options(GetParam()));
  LoadedScene streaming = load(two_sheets(), test_options(GetParam()));
  const auto set_step = [](LoadedScene& loaded, const Positions3& from, const Positions3& to) {
    loaded.pipeline.scene.set_positions(loaded.ids[1], from, to);
  };
  Positions3 from = end_of_step(plain.scene, 0);
  Positions3 to = end_of_step(plain.scene, 1);
  std::size_t contacts = 0;
  set_step(streaming, from, to);
  Ticket ticket = streaming.pipeline.query.start();
  for (int step = 1; step <= kSteps; ++step) {
    set_step(plain, from, to);
    const Span<const Contact> expected = plain.pipeline.detect();
    from = std::exchange(to, end_of_step(plain.scene, step + 1));
    set_step(streaming, from, to);
    const Span<const Contact> found = ticket.wait();
    ASSERT_TRUE(identical(expected, found))
        << "step " << step << ": " << found.size() << " instead of " << expected.size();
    ASSERT_EQ(streaming.pipeline.query.statistics().vt_contacts, plain.pipeline.query.statistics().vt_contacts);
    contacts += found.size();
    ticket = streaming.pipeline.query.start();
  }
  EXPECT_GT(contacts, 10'000U);
}

TEST_P(AsynchronousUse, changes_concern_the_next_detection) {
  const Scene scene = two_sheets();
  const Mesh ball = moved(icosphere(2, 0.4), {0.5, 0.5, 0.0});
  Scene changed = scene;
  changed[0] = still(ball, everything(0.02F));
  changed[1].settings.margin = 0.08F;
  changed[1].x_t0 = translated(scene[1].x_t0, {0.02, 0.0, 0.0});
  changed.push_back(still(moved(ball, {0.3, 0.0, 0.1}), everything(0.03F)));
  ASSERT_FALSE(identical(fresh(scene), fresh(changed)));

  LoadedScene loaded = load(scene, test_options(GetParam()));
  CollisionPipeline& pipeline = loaded.pipeline;
  pipeline.query.set_pair_filter([](BodyId, BodyId) { return true; });
  const BodyId removed =
      pipeline.scene.add_body({ball.triangles, static_cast<std::uint32_t>(ball.positions.size()), {}});
  const Positions3 far_away = translated(ball.positions, {100.0, 0.0, 0.0});
  pipeline.scene.set_positions(removed, far_away);
  Ticket ticket = pipeline.query.start();
  pipeline.query.set_pair_filter({});
  pipeline.scene.set_log([](LogLevel, std::string_view) {});
  pipeline.scene.remove_body(removed);
  pipeline.scene.update_body(
      loaded.ids[0], {changed[0].triangles, static_cast<std::uint32_t>(changed[0].x_t1.size()), changed[0].settings});
  pipeline.scene.set_positions(loaded.ids[0], changed[0].x_t0, changed[0].x_t1);
  pipeline.scene.set_settings(loaded.ids[1], changed[1].settings);
  pipeline.scene.set_positions(loaded.ids[1], changed[1].x_t0, changed[1].x_t1);
  const BodyId added = pipeline.scene.add_body(
      {changed[2].triangles, static_cast<std::uint32_t>(changed[2].x_t1.size()), changed[2].settings});
  pipeline.scene.set_positions(added, changed[2].x_t0, changed[2].x_t1);
  EXPECT_TRUE(identical(fresh(scene), ticket.wait()));
  EXPECT_EQ(pipeline.query.statistics().bodies, 3U) << "those of the detection that was waited for";
  std::vector<FeaturePair> found = features_of(pipeline.detect());
  for (FeaturePair& pair : found) {
    for (std::uint32_t* body : {&pair.body_a, &pair.body_b}) {
      if (*body == added.value) *body = 2;  // its place among those that are left
    }
  }
  EXPECT_EQ(found, features_of(fresh(changed)));
}

TEST_P(AsynchronousUse, a_detection_that_nobody_waits_for_makes_room_for_the_next) {
  Scene scene = two_sheets();
  LoadedScene loaded = load(scene, test_options(GetParam()));
  static_cast<void>(loaded.pipeline.query.start());
  scene[1].x_t1 = end_of_step(scene, 10);
  loaded.pipeline.scene.set_positions(loaded.ids[1], scene[1].x_t0, scene[1].x_t1);
  EXPECT_TRUE(identical(fresh(scene), loaded.pipeline.query.start().wait()));
  static_cast<void>(loaded.pipeline.query.start());
  EXPECT_TRUE(identical(fresh(scene), loaded.pipeline.detect()));
}

TEST_P(AsynchronousUse, new_options_end_what_runs) {
  LoadedScene loaded = load(two_sheets(), test_options(GetParam()));
  Ticket ticket = loaded.pipeline.query.start();
  loaded.pipeline.set_options(test_options(GetParam(), BroadPhase::uniform));
  EXPECT_EQ(loaded.pipeline.query.statistics().bodies, 0U) << "of no detection yet";
  EXPECT_THROW(ticket.wait(), Error);
  EXPECT_TRUE(identical(fresh(two_sheets()), loaded.pipeline.detect()));
}

// Large enough that the detection still runs when the pipeline is destroyed.
TEST_P(AsynchronousUse, a_pipeline_may_go_while_a_detection_runs) {
  for (int run = 0; run < 3; ++run) {
    LoadedScene loaded = load(two_sheets(120), test_options(GetParam()));
    static_cast<void>(loaded.pipeline.query.start());
  }
}

TEST_P(AsynchronousUse, a_pipeline_may_be_assigned_to_while_a_detection_runs) {
  LoadedScene loaded = load(two_sheets(120), test_options(GetParam()));
  static_cast<void>(loaded.pipeline.query.start());
  LoadedScene other = load(two_sheets(), test_options(GetParam()));
  Ticket ticket = other.pipeline.query.start();
  loaded.pipeline = std::move(other.pipeline);
  EXPECT_TRUE(identical(fresh(two_sheets()), ticket.wait()));
}

TEST_P(AsynchronousUse, a_pipeline_that_was_moved_from_says_so) {
  LoadedScene loaded = load(two_sheets(), test_options(GetParam()));
  CollisionPipeline taken = std::move(loaded.pipeline);
  CollisionPipeline& empty = loaded.pipeline;
  const auto says_so = [](const auto& call) {
    try {
      call();
      ADD_FAILURE() << "no exception";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("moved"));
    }
  };
  says_so([&] { empty.scene.add_body({}); });
  says_so([&] { empty.set_options({}); });
  says_so([&] { empty.options(); });
  says_so([&] { empty.detect(); });
  says_so([&] { static_cast<void>(empty.query.start()); });
  empty = std::move(taken);
  EXPECT_TRUE(identical(fresh(two_sheets()), empty.detect()));
}

INSTANTIATE_TEST_SUITE_P(Kinds, AsynchronousUse, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

}  // namespace
}  // namespace softcd::test
