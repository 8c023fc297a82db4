#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

TEST(BenchImpulses, are_the_changes_of_momentum_within_one_percent) {
  const TemporaryFolder folder;
  const Result result = run_program(SOFTCD_BENCH, "impulses --json " + folder.file("json"), folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json runs = nlohmann::json::parse(folder.read("json")).at("impulses");
  EXPECT_EQ(runs.size(), 16U) << "eight set-ups, each with dcd and ccd";
  for (const auto& run : runs) {
    EXPECT_GT(run["needed"], 1) << run;
    EXPECT_LT(run["difference"], 0.01) << run;
    EXPECT_EQ(run["is_asleep"], run["set_up"] == "sleeping cloth on a box") << run;
  }
}

}  // namespace
}  // namespace softcd::test
