// Steps in which calls of the CUDA runtime fail: Bullet's world continues, and contacts are right.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "any_simulation.hpp"
#include "backend_under_test.hpp"
#include "failing_cuda_calls.hpp"
#include "layers.hpp"

namespace softcd::test {
namespace {

/// In them lists grow, a graph is captured, and it is replayed. One more follows, in which nothing fails.
constexpr int kFailingSteps = 3;

/// With more triangles than what Backend::automatic leaves to the CPU.
constexpr int kNodesPerSide = 8;

/// A contact's weights on both sides, normal, depth and time of impact.
using Numbers = std::array<btScalar, 11>;

/// The results of a step.
struct Step {
  LayerContacts contacts;
  std::vector<Numbers> numbers;
};

Step step_of(Layers& sheets) {
  Step step{sheets.contacts(), {}};
  for (const bullet::BodyPairContacts& pair : sheets.simulation().detection().body_contacts()) {
    for (const bullet::BodyContact& contact : pair.contacts) {
      const auto& [a0, a1, a2] = contact.a.weights;
      const auto& [b0, b1, b2] = contact.b.weights;
      const btVector3& normal = contact.normal;
      step.numbers.push_back(
          {a0, a1, a2, b0, b1, b2, normal.x(), normal.y(), normal.z(), contact.depth, contact.time_of_impact});
    }
  }
  std::sort(step.numbers.begin(), step.numbers.end());
  return step;
}

bullet::Settings settings_for(Backend backend) {
  bullet::Settings settings = settings_on(backend, Detection::ccd);
  settings.read_out = bullet::ReadOut::contacts;
  return settings;
}

/// Steps that each detector has failed in.
struct Failures {
  std::uint64_t contacts = 0;
  std::uint64_t meshes = 0;
  std::uint64_t crossings = 0;

  bool any() const { return contacts + meshes + crossings > 0; }
};

Failures failures_of(const bullet::WorldDetection& detection) {
  return {detection.contact_report().failed_steps(), detection.rigid_mesh_report().failed_steps(),
          detection.crossing_report().failed_steps()};
}

/// All steps of a world in which nothing fails.
std::vector<Step> live(Layers& sheets) {
  std::vector<Step> steps;
  for (int i = 0; i <= kFailingSteps; ++i) {
    sheets.step();
    steps.push_back(step_of(sheets));
  }
  return steps;
}

/// Does the same in a world of Bullet's own, which reports no numbers.
std::vector<LayerContacts> live_without_softcd(Layers& sheets) {
  std::vector<LayerContacts> steps;
  for (int i = 0; i <= kFailingSteps; ++i) {
    sheets.step();
    steps.push_back(sheets.contacts());
  }
  return steps;
}

/// Every how many calls one fails: each of them where SOFTCD_CUDA_CALL_STRIDE is 1.
std::uint64_t stride() {
  const char* const text = std::getenv("SOFTCD_CUDA_CALL_STRIDE");
  return text == nullptr ? 11 : std::strtoull(text, nullptr, 10);
}

class FailedCudaSteps : public testing::TestWithParam<std::tuple<World, Backend, Fails>> {
 protected:
  void SetUp() override {
    const std::string reason = why_missing(Backend::cuda);
    if (!reason.empty()) GTEST_SKIP() << reason;
  }

  /// `make(backend)` makes sheets in a world; `bullets` are in Bullet's own.
  template <class Make>
  void fail_each(const Make& make, Layers& bullets) {
    bullets_own_ = live_without_softcd(bullets);
    expected_ = live(*make(Backend::cpu));
    ASSERT_FALSE(expected_.back().contacts.soft.empty() || expected_.back().contacts.rigid.empty());
    ASSERT_FALSE(expected_.back().numbers.empty());
    {
      const auto sheets = make(backend_);
      const std::vector<Step> found = live(*sheets);
      EXPECT_EQ(sheets->detection().contact_report().backend(), Backend::cuda);
      for (std::size_t i = 0; i < found.size(); ++i) expect_same(expected_[i], found[i]);
    }
    const std::int64_t living = living_cuda_objects();
    std::uint64_t n = 1;
    std::uint64_t fallen_back = 0;
    for (bool has_failed = true; has_failed && !HasFailure(); n += stride()) {
      SCOPED_TRACE(testing::Message() << "call " << n);
      {
        const auto sheets = make(backend_);
        has_failed = fail(*sheets, n);
        fallen_back += failures_of(sheets->detection()).any();
      }
      EXPECT_EQ(living_cuda_objects(), living);
    }
    EXPECT_GT(n, 100U);
    EXPECT_EQ(fallen_back > 0, backend_ == Backend::cuda) << "with Backend::automatic the CPU takes over";
    RecordProperty("calls", std::to_string(n - 1));
  }

 private:
  static void expect_same(const Step& expected, const Step& found) {
    EXPECT_EQ(found.contacts.soft, expected.contacts.soft);
    EXPECT_EQ(found.contacts.rigid, expected.contacts.rigid);
    EXPECT_EQ(found.numbers, expected.numbers);
  }

  /// A life in which the n-th call fails. Returns whether there were that many.
  bool fail(Layers& sheets, std::uint64_t n) {
    FailingCudaCall failing(n, fails_);
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "step " << i);
      if (i == kFailingSteps) failing.end();
      const Failures before = failures_of(sheets.detection());
      EXPECT_NO_THROW(sheets.step());
      const Failures after = failures_of(sheets.detection());
      const Step found = step_of(sheets);
      const bool has_bullets_soft = after.contacts > before.contacts;
      const bool has_bullets_rigid = after.meshes > before.meshes;
      EXPECT_EQ(found.contacts.soft, has_bullets_soft ? bullets_own_[i].soft : expected_[i].contacts.soft);
      EXPECT_EQ(found.contacts.rigid, has_bullets_rigid ? bullets_own_[i].rigid : expected_[i].contacts.rigid);
      if (!has_bullets_soft && !has_bullets_rigid) {
        EXPECT_EQ(found.numbers, expected_[i].numbers);
      }
      if (i == kFailingSteps) {
        EXPECT_EQ(after.contacts + after.meshes + after.crossings, before.contacts + before.meshes + before.crossings);
      }
    }
    return failing.has_failed();
  }

  Backend backend_ = std::get<Backend>(GetParam());
  Fails fails_ = std::get<Fails>(GetParam());
  std::vector<Step> expected_;              ///< by steps
  std::vector<LayerContacts> bullets_own_;  ///< the same, without softcd
};

TEST_P(FailedCudaSteps, leave_a_world_that_goes_on) {
  const World world = std::get<World>(GetParam());
  const auto make = [&](Backend backend) {
    return std::make_unique<Layers>(world, settings_for(backend), kNodesPerSide);
  };
  Layers bullets(world, std::nullopt, kNodesPerSide);
  fail_each(make, bullets);
}

std::string name_of(const testing::TestParamInfo<std::tuple<World, Backend, Fails>>& parameter) {
  const auto [world, backend, fails] = parameter.param;
  return name_of(world) + (backend == Backend::cuda ? "_cuda" : "_automatic") +
         (fails == Fails::once ? "_once" : "_from_then_on");
}

INSTANTIATE_TEST_SUITE_P(Worlds, FailedCudaSteps,
                         testing::Combine(testing::Values(World::one_line, World::attached, World::deformable),
                                          testing::Values(Backend::cuda, Backend::automatic),
                                          testing::Values(Fails::once, Fails::from_then_on)),
                         [](const auto& parameter) { return name_of(parameter); });

}  // namespace
}  // namespace softcd::test
