#include <gtest/gtest.h>

#include <cstddef>
#include <ostream>
#include <string>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "recorded_steps.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {
namespace {

/// A step of tests/recorded_steps.
struct RecordedStep {
  const char* name;
  std::size_t crossings;  ///< least number of pairs of features that meet during the step

  friend std::ostream& operator<<(std::ostream& out, const RecordedStep& step) { return out << step.name; }
};

class RecordedSteps : public testing::TestWithParam<RecordedStep> {
 protected:
  Scene scene_ = recorded_step(GetParam().name);
};

TEST_P(RecordedSteps, continuous_detection_finds_what_brute_force_finds) {
  EXPECT_GE(expect_continuous_contacts(scene_, test_options(Detection::ccd)), GetParam().crossings);
}

TEST_P(RecordedSteps, conservative_detection_finds_what_brute_force_finds) {
  PipelineOptions options = test_options(Detection::ccd);
  options.accuracy = Accuracy::conservative;
  EXPECT_GE(expect_continuous_contacts(scene_, options, {}, 1e-6 * half_extent_of(scene_)), GetParam().crossings);
}

TEST_P(RecordedSteps, discrete_detection_finds_what_brute_force_finds) {
  // The margins of both sides add up to half a mean edge.
  const double edge = mean_edge_length({scene_[0].triangles, scene_[0].x_t1});
  scene_[0].settings.margin = static_cast<float>(0.25 * edge);
  DiscreteRules rules;
  rules.absolute_band = 0x1p-22 * half_extent_of(scene_);
  EXPECT_GT(expect_discrete_contacts(scene_, test_options(Detection::dcd), rules), 0U);
}

INSTANTIATE_TEST_SUITE_P(Steps, RecordedSteps,
                         testing::Values(RecordedStep{"folding-cloth", 53}, RecordedStep{"n-body", 40},
                                         RecordedStep{"reef-knot", 0}, RecordedStep{"tube", 0}),
                         [](const auto& test) {
                           std::string name = test.param.name;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

}  // namespace
}  // namespace softcd::test
