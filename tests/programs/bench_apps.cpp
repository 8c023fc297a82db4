#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
      const bool is_parted = run["detection"] == "balanced" && run["world"] != "deformable";
      EXPECT_EQ(run["most_crossings"] == 0, is_parted) << run;
    }
    EXPECT_LT(run["farthest"], 10) << run;
  }
}

TEST(BenchApps, of_soft_bodies_on_soft_bodies_have_no_more_crossings_than_with_bullet) {
  const TemporaryFolder folder;
  const Result result = run_program(SOFTCD_BENCH,
                                    "apps --app pile-of-balls,pile-of-cloths --world soft-rigid --iterations 4 "
                                    "--detection bullet,balanced --json " +
                                        folder.file("json"),
                                    folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json runs = nlohmann::json::parse(folder.read("json")).at("apps");
  ASSERT_EQ(runs.size(), 4U);
  for (std::size_t app = 0; app < 4; app += 2) {
    EXPECT_LE(runs[app + 1]["frames_with_crossings"], runs[app]["frames_with_crossings"]) << runs[app + 1];
    EXPECT_EQ(runs[app + 1]["crossings_at_end"], 0) << runs[app + 1];
    EXPECT_EQ(runs[app + 1]["lost_bodies"], 0) << runs[app + 1];
    EXPECT_LE(runs[app + 1]["gained_energy"], runs[app]["gained_energy"]) << runs[app + 1];
  }
}

/// In the deformable world each contact of a node slows the approach by itself. With one of them for all, the cloths
/// would go through each other.
TEST(BenchApps, of_cloths_on_cloths_have_no_crossing_with_fast_in_the_deformable_world) {
  const TemporaryFolder folder;
  const Result result = run_program(
      SOFTCD_BENCH,
      "apps --app pile-of-cloths --world deformable --detection fast --seconds 1.5 --json " + folder.file("json"),
      folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json runs = nlohmann::json::parse(folder.read("json")).at("apps");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0]["frames_with_crossings"], 0) << runs[0];
}

TEST(BenchApps, say_in_which_figures_a_preset_is_worse_than_bullet) {
  const TemporaryFolder folder;
  const Result result =
      run_program(SOFTCD_BENCH,
                  "apps --app flag,locked-balls --world deformable --seconds 2 --json " + folder.file("json"), folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json runs = nlohmann::json::parse(folder.read("json")).at("apps");
  ASSERT_EQ(runs.size(), 8U);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const nlohmann::json& run = runs[i];
    const nlohmann::json& bullet = runs[i - i % 4];
    EXPECT_EQ(run.contains("worse"), i % 4 != 0) << run;
    if (i % 4 == 0) continue;
    std::vector<std::string> worse;
    if (run["frames_with_crossings"] > bullet["frames_with_crossings"]) worse.emplace_back("crossings");
    const double gained = run["gained_energy"];
    // The wind blows the flag.
    const double allowed = 1.1 * double(bullet["gained_energy"]) + 0.01 * double(bullet["most_energy"]);
    if (run["app"] == "locked-balls" && gained > allowed) worse.emplace_back("energy");
    EXPECT_EQ(run["worse"], worse) << run << bullet;
  }
  EXPECT_THAT(result.output, testing::HasSubstr("balanced: 0 of 2 rows worse than Bullet alone"));
}

/// Returns the results of six frames of an app, one for each value of an option.
std::vector<nlohmann::json> results_with(const std::string& option, const std::vector<std::string>& values) {
  const TemporaryFolder folder;
  std::vector<nlohmann::json> results;
  for (const std::string& value : values) {
    std::string arguments =
        "apps --app locked-balls --world soft-rigid --iterations 4 --detection bullet --seconds 0.1 ";
    arguments.append(option).append(" ").append(value).append(" --json ").append(folder.file("json"));
    const Result result = run_program(SOFTCD_BENCH, arguments, folder);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    const nlohmann::json apps = nlohmann::json::parse(folder.read("json")).at("apps");
    EXPECT_EQ(apps.size(), 1U);
    EXPECT_EQ(apps[0]["frames"], 6);
    results.push_back(apps[0]);
  }
  return results;
}

TEST(BenchApps, take_the_medians_of_several_starts) {
  const std::vector<nlohmann::json> results = results_with("--starts", {"1", "3"});
  EXPECT_NE(results[0]["farthest"], results[1]["farthest"]) << "the bodies are shifted";
}

TEST(BenchApps, tell_energy_that_a_fall_sets_free_from_energy_that_is_added) {
  const TemporaryFolder folder;
  const Result result = run_program(SOFTCD_BENCH,
                                    "apps --app terrain --world soft-rigid --iterations 1 --detection bullet "
                                    "--seconds 0.5 --json " +
                                        folder.file("json"),
                                    folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json run = nlohmann::json::parse(folder.read("json")).at("apps")[0];
  EXPECT_GT(run["most_energy"], 10) << run;
  EXPECT_LT(run["gained_energy"], 0.01) << run;
}

TEST(BenchApps, split_steps) {
  const std::vector<nlohmann::json> results = results_with("--splits", {"1", "4"});
  EXPECT_NE(results[0]["farthest"], results[1]["farthest"]);
}

TEST(BenchApps, lose_no_bodies_that_a_held_body_carries) {
  const TemporaryFolder folder;
  // The load stretches the bag to below the height at which free bodies count as lost.
  const Result result = run_program(
      SOFTCD_BENCH,
      "apps --app bag --world deformable --detection balanced --seconds 0.85 --json " + folder.file("json"), folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json runs = nlohmann::json::parse(folder.read("json")).at("apps");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_GT(runs[0]["farthest"], 2.5);
  EXPECT_EQ(runs[0]["lost_bodies"], 0);
}

TEST(BenchApps, refuse_apps_that_there_are_not) {
  const TemporaryFolder folder;
  expect_refused(SOFTCD_BENCH, "apps --app teapot", folder, "there is no app 'teapot'");
}

}  // namespace
}  // namespace softcd::test
