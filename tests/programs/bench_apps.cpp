#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

TEST(BenchApps, run_in_every_world_with_every_preset) {
  const TemporaryFolder folder;
  const Result result = run_program(
      SOFTCD_BENCH, "apps --app curtain,locked-balls --iterations 1,4 --seconds 0.1 --json " + folder.file("json"),
      folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json runs = nlohmann::json::parse(folder.read("json")).at("apps");
  // Two apps, two classic worlds with two numbers of iterations and a deformable one, four ways to detect.
  EXPECT_EQ(runs.size(), 2U * (2 * 2 + 1) * 4);
  for (const auto& run : runs) {
    EXPECT_EQ(run["frames"], 6) << run;
    EXPECT_EQ(run["lost_bodies"], 0) << run;
    if (run["app"] == "locked-balls") {
      EXPECT_GT(run["most_crossings"], 0) << run;
    }
    EXPECT_LT(run["farthest"], 10) << run;
  }
}

TEST(BenchApps, refuse_apps_that_there_are_not) {
  const TemporaryFolder folder;
  expect_refused(SOFTCD_BENCH, "apps --app teapot", folder, "there is no app 'teapot'");
}

}  // namespace
}  // namespace softcd::test
