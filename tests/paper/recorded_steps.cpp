#include <gtest/gtest.h>

#include <iostream>

#include "expectations.hpp"
#include "ground_truth.hpp"
#include "paper_outcome.hpp"

namespace softcd::paper {
namespace {

class PrintedSchemeOnSteps : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Steps, PrintedSchemeOnSteps, testing::Values("cloth-ball", "armadillo-rollers"));

TEST_P(PrintedSchemeOnSteps, reports_nothing_that_is_not_there) {
  const std::filesystem::path folder = test::data_folder("ccd-steps");
  if (folder.empty()) GTEST_SKIP() << test::missing_data("ccd-steps");
  const test::Scene scene = test::read_ground_truth(folder, GetParam()).scene;
  const PipelineOptions options = test::test_options(Detection::ccd);
  const std::vector<Contact> exact = test::detect_once(scene, options);
  const std::vector<Contact> contacts = outcome_by_paper(scene, options).contacts;
  const test::Difference difference = test::compare({test::features_of(exact), {}}, test::features_of(contacts));
  EXPECT_TRUE(difference.extra.empty()) << test::describe(difference);
  EXPECT_GT(contacts.size(), exact.size() / 2);
  std::cout << GetParam() << ": " << difference.missed.size() << " of " << exact.size() << " contacts missed\n";
}

}  // namespace
}  // namespace softcd::paper
