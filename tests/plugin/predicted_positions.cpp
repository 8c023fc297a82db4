#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "extent_prediction.hpp"
#include "pretended_device.hpp"
#include "random.hpp"

// Detections with predicted positions find the same contacts as those that read positions first.
namespace softcd::test {
namespace {

/// Two bodies that move slowly, the same in both scenes.
class PredictedPositionsTest : public DevicePositionsTest {
 protected:
  void SetUp() override {
    for (std::uint64_t i = 0; i < 2; ++i) {
      bodies_.push_back(soup(i, 150));
      host_.add(bodies_.back());
      device_.add(bodies_.back());
    }
  }

  void set(std::size_t i, bool moves = true) {
    host_.set(i, bodies_[i], form_, moves, false);
    device_.set(i, bodies_[i], form_, moves, true);
  }
  void move(std::size_t i, const Vec3d& by) {
    bodies_[i].x_t0 = std::exchange(bodies_[i].x_t1, translated(bodies_[i].x_t1, by));
  }
  /// Moves both scenes by a step, and detects.
  void step(const Vec3d& by) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      move(i, i == 0 ? by : -1.0 * by);
      set(i);
    }
    detect();
  }
  void detect() {
    const std::vector<Contact> expected = host_.detect(options_);
    contact_count_ += expected.size();
    ASSERT_TRUE(identical(expected, device_.detect(options_)));
    EXPECT_EQ(device_.query().statistics().vt_contacts, host_.query().statistics().vt_contacts);
  }
  void expect_in_vain(int surveys) {
    if (backend_under_test() == Backend::cuda) return;
    EXPECT_EQ(survey_counts_.in_vain, surveys);
  }
  void expect_some_in_vain() {
    if (backend_under_test() == Backend::cuda) return;
    EXPECT_GT(survey_counts_.in_vain, 0);
  }
  void expect_surveys(int all, int in_vain) {
    if (backend_under_test() == Backend::cuda) return;
    EXPECT_GE(survey_counts_.all, all);
    EXPECT_LE(survey_counts_.in_vain, in_vain);
  }

  static constexpr Vec3d kSlowly{0.003, -0.002, 0.001};
  QueryOptions options_ = looking_for(Detection::ccd);
  Form form_;
  Scene bodies_;
  LoadedCore host_ = on_host();
  LoadedCore device_ = on_device();
  std::size_t contact_count_ = 0;
};

TEST_F(PredictedPositionsTest, are_detected_without_looking_first) {
  for (int i = 0; i < 40; ++i) step(kSlowly);
  expect_surveys(30, 1);
  EXPECT_GT(contact_count_, 1000U);
}

TEST_F(PredictedPositionsTest, may_be_doubles_where_margins_do_not_cover_their_rounding) {
  form_.is_double = true;
  for (const Accuracy accuracy : {Accuracy::precise, Accuracy::fast}) {
    options_.accuracy = accuracy;
    for (int i = 0; i < 20; ++i) step(kSlowly);
  }
  expect_surveys(20, 8);
  options_.accuracy = Accuracy::conservative;
  const int before = survey_counts_.all;
  for (int i = 0; i < 12; ++i) step(kSlowly);
  EXPECT_EQ(survey_counts_.all, before);
  EXPECT_GT(contact_count_, 1000U);
}

/// In the second half they are far from 0, where they are rounded relative to an origin that moves along.
TEST_F(PredictedPositionsTest, may_be_doubles_between_which_conservative_queries_look) {
  Random random(3);
  form_.is_double = true;
  for (int i = 0; i < 60; ++i) {
    if (i == 30) {
      for (SceneBody& body : bodies_) body.x_t0 = body.x_t1 = translated(body.x_t1, {1000.1, 0, 0});
    }
    options_.accuracy = random.chance(0.3) ? Accuracy::conservative : Accuracy::precise;
    if (random.chance(0.1)) form_.is_double = !form_.is_double;
    ASSERT_NO_FATAL_FAILURE(step(random.chance(0.05) ? Vec3d{0.5, 0, 0} : kSlowly)) << "step " << i;
    ASSERT_NO_FATAL_FAILURE(detect()) << "step " << i;
  }
  EXPECT_GT(contact_count_, 1000U);
}

TEST_F(PredictedPositionsTest, are_looked_at_again_where_they_are_not_as_predicted) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto step_slowly = [&] {
    for (int i = 0; i < 12; ++i) step(kSlowly);
  };
  step_slowly();
  step({0.7, 0.1, 0.2});
  step_slowly();
  for (int i = 0; i < 2; ++i) {  // far away, so that the scene's origin moves, and back
    for (SceneBody& body : bodies_) {
      body.x_t1 = body.x_t0 = translated(body.x_t1, i == 0 ? Vec3d{900, 0, 0} : Vec3d{-900, 0, 0});
    }
    step_slowly();
  }
  const Vec3d x = std::exchange(bodies_[0].x_t1[7], {kNaN, 0, 0});
  set(0);
  detect();
  bodies_[0].x_t1[7] = x;
  step_slowly();
  step({0, 0, 0});
  step({0, 0, 0});  // nothing moves
  for (std::size_t b = 0; b < 2; ++b) set(b, false);
  detect();
  step_slowly();
  expect_some_in_vain();
}

TEST_F(PredictedPositionsTest, do_not_outlive_what_else_changes) {
  Random random(5);
  for (int i = 0; i < 80; ++i) {
    if (random.chance(0.05)) {
      bodies_.push_back(soup(random.bits(), 30));
      for (LoadedCore* const core : {&host_, &device_}) core->add(bodies_.back());
      set(bodies_.size() - 1);
    }
    if (random.chance(0.05)) {
      const auto b = random.below(static_cast<std::uint32_t>(bodies_.size()));
      bodies_[b].settings.margin = static_cast<float>(random.uniform(0.01, 0.2));
      for (LoadedCore* const core : {&host_, &device_}) core->scene().set_settings(core->ids()[b], bodies_[b].settings);
    }
    if (random.chance(0.1)) {
      options_ = looking_for(random.chance(0.5) ? Detection::ccd : Detection::dcd);
      if (random.chance(0.5)) options_.motion_margin = options_.detection == Detection::dcd ? 0.5F : 0.0F;
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (i % 20 > 15 && b == 1) continue;  // not every body in every step
      move(b, random.chance(0.02) ? 0.5 * random.direction() : kSlowly);
      set(b);
    }
    ASSERT_NO_FATAL_FAILURE(detect()) << "step " << i;
  }
  expect_surveys(15, 30);
}

TEST_F(PredictedPositionsTest, may_be_set_for_the_next_step_while_a_detection_runs) {
  for (int times = 0; times < 2; ++times) {
    for (int i = 0; i < 40; ++i) step(kSlowly);  // whatever failed before
    const int before = survey_counts_.in_vain;
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, {0.6, 0, 0});  // against the prediction
      set(b);
    }
    const std::vector<Contact> expected = host_.detect(options_);
    const std::uint64_t number = device_.query().start(Pairs::all);
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, {0, 0.3, 0});
      if (times == 0) set(b);
    }
    for (LoadedCore* const core : {&host_, &device_}) core->scene().set_settings(core->ids()[0], everything(0.2F));
    const Span<const Contact> found = device_.query().wait(number);
    ASSERT_TRUE(identical(expected, found));
    expect_in_vain(before + 1);
    detect();
  }
}

/// The second of two flat sheets comes so near the first that they touch within the prediction for the second one
/// alone.
TEST_F(DevicePositionsTest, predicted_of_some_bodies_are_not_taken_for_those_of_others) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  const Mesh sheet = grid_cloth(5, 5, 0.25);
  BodySettings settings = everything(0.005F);
  settings.self_collision = false;
  std::vector<SceneBody> bodies;
  for (int b = 0; b < 2; ++b) {
    bodies.push_back(still(moved(sheet, {0, 0, 0.028 * b}), settings));
    for (LoadedCore* const core : {&host, &device}) core->add(bodies.back());
  }
  const auto set = [&](std::size_t b, const Vec3d& by) {
    bodies[b].x_t1 = translated(bodies[b].x_t0, by);
    host.set(b, bodies[b], {}, true, false);
    device.set(b, bodies[b], {}, true, true);
    bodies[b].x_t0 = bodies[b].x_t1;
  };
  const auto detect = [&](bool touch) {
    const std::vector<Contact> expected = host.detect(looking_for(Detection::ccd));
    EXPECT_EQ(expected.empty(), !touch);
    EXPECT_TRUE(identical(expected, device.detect(looking_for(Detection::ccd))));
  };
  const Vec3d down = {0, 0, -0.005};
  const Vec3d nowhere = {0, 0, 0};
  for (int i = 0; i < 2; ++i) {
    set(0, nowhere);
    set(1, down);
    detect(false);
  }
  set(0, nowhere);
  detect(false);
  set(0, nowhere);
  set(1, 1.9 * down);
  detect(true);
  EXPECT_EQ(survey_counts_.in_vain, 0);
}

/// Two bodies are far apart, and one is suddenly at the other one's place.
TEST_F(DevicePositionsTest, that_come_together_from_far_away_are_not_missed) {
  LoadedCore host = on_host();
  LoadedCore device = on_device();
  std::vector<SceneBody> bodies = {soup(1, 100), soup(2, 100)};
  for (SceneBody& body : bodies) {
    body.settings.self_collision = false;
    for (LoadedCore* const core : {&host, &device}) core->add(body);
  }
  for (int i = 0; i < 9; ++i) {
    for (std::size_t b = 0; b < 2; ++b) {
      const Vec3d by = b == 1 && i < 8 ? Vec3d{30, 0, 0} : Vec3d{0, 0.002 * i, 0};
      SceneBody body = bodies[b];
      body.x_t0 = body.x_t1 = translated(body.x_t1, by);
      body.x_t1[0].z += 0.01;
      host.set(b, body, {}, true, false);
      device.set(b, body, {}, true, true);
    }
    const std::vector<Contact> expected = host.detect(looking_for(Detection::ccd));
    EXPECT_EQ(expected.empty(), i < 8);
    EXPECT_TRUE(identical(expected, device.detect(looking_for(Detection::ccd)))) << "step " << i;
  }
}

/// The scene's origin follows its extent, though no body leaves its prediction.
TEST_F(PredictedPositionsTest, are_looked_at_again_where_the_origin_moves) {
  options_.accuracy = Accuracy::fast;
  double low = 1e9;
  double high = -1e9;
  for (const SceneBody& body : bodies_) {
    for (const Vec3d& x : body.x_t1) {
      low = std::min(low, x.x);
      high = std::max(high, x.x);
    }
  }
  // From half its width from 0 on a scene is far away.
  const double offset = 0.5 * (high - low) - low - 0.03;
  for (SceneBody& body : bodies_) body.x_t0 = body.x_t1 = translated(body.x_t1, {offset, 0, 0});
  for (int i = 0; i < 30; ++i) {
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, {0.003, 0, 0});
      set(b);
    }
    detect();
  }
  expect_some_in_vain();
}

TEST_F(PredictedPositionsTest, say_on_the_device_whether_they_were_not_as_predicted) {
  options_.contacts_on_device = true;
  device_.query().set_options(options_);
  QueryOptions on_the_host = options_;
  on_the_host.contacts_on_device = false;
  for (int i = 0; i < 20; ++i) {
    for (std::size_t b = 0; b < 2; ++b) {
      move(b, i == 15 ? Vec3d{0.6, 0, 0} : kSlowly);
      set(b);
    }
    const std::vector<Contact> expected = host_.detect(on_the_host);
    const DeviceContacts found = device_.query().wait_on_device(device_.query().start(Pairs::all));
    ASSERT_EQ(found.count, expected.size()) << "step " << i;
    const std::vector<std::byte> bytes = read_device(backend_under_test(), found.data, found.count * sizeof(Contact));
    EXPECT_EQ(std::memcmp(bytes.data(), expected.data(), bytes.size()), 0) << "step " << i;
  }
  expect_surveys(10, 2);
}

/// Otherwise margins of conservative detections would compensate rounding of the earlier doubles.
TEST(ExtentPrediction, has_nothing_rounded) {
  const Vec3d x{1, 2, 3};
  std::vector<Body> bodies(1);
  const Positions on_device = Positions::on_device(&x.x, 1, sizeof(Vec3d));
  bodies[0].positions.set(on_device, on_device);
  StepSurvey seen;
  seen.t1.extent.extend(x);
  seen.t1.is_rounded = true;
  seen.t0 = seen.t1;
  bodies[0].positions.set_survey(seen);
  ExtentPrediction prediction;
  for (int detection = 0; detection < 2; ++detection) prediction.learn(bodies);
  ASSERT_TRUE(prediction.is_known());
  EXPECT_FALSE(prediction.of(0).t0.is_rounded);
  EXPECT_FALSE(prediction.of(0).t1.is_rounded);
  EXPECT_TRUE(is_within(seen.t1.extent, prediction.of(0).t1.extent));
}

}  // namespace
}  // namespace softcd::test
