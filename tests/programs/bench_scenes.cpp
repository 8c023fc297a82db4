#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;
using testing::StartsWith;

class BenchScenes : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_BENCH, "scenes " + arguments, folder_); }

  TemporaryFolder folder_;
};

TEST_F(BenchScenes, steps_of_a_simulation_are_measured) {
  const Result result =
      run("--scene n-body,tube --size default --steps 12 --samples 3 --repeat 1 --backend cpu --json " +
          folder_.file("json") + " --markdown " + folder_.file("tables.md") + " --csv " + folder_.file("rows.csv"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  std::set<std::string> measured;
  const nlohmann::json json = nlohmann::json::parse(folder_.read("json"));
  for (const auto& row : json.at("simulated_scenes")) {
    EXPECT_GT(row["triangles"], 1000) << row;
    EXPECT_GT(row["tests"], 0) << row;
    EXPECT_GT(row["ms"]["total"], row["ms"]["transfer"]) << row;
    measured.insert(row["scene"].get<std::string>() + row["sample"].dump() + row["detection"].get<std::string>());
  }
  EXPECT_EQ(measured.size(), 2U * 3U * 2U);
  EXPECT_EQ(json.at("paper").size(), 6U);
  EXPECT_FALSE(json.at("machine").get<std::string>().empty());
  EXPECT_THAT(json.at("date").get<std::string>(), MatchesRegex("20[0-9][0-9]-[01][0-9]-[0-3][0-9]"));
  const std::string csv = folder_.read("rows.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 12);
  EXPECT_THAT(csv, StartsWith("scene,sample,backend,"));
  EXPECT_THAT(csv, HasSubstr(",ms.total,"));
  const std::string tables = folder_.read("tables.md");
  for (const char* heading :
       {"### Simulated scenes", "### Shares of a continuous detection", "### Cell size", "### Kept pairs"}) {
    EXPECT_THAT(tables, HasSubstr(heading));
  }
  std::istringstream kept_rows(tables.substr(tables.rfind("| tube")));
  std::string text;
  int contacts[3] = {};
  kept_rows >> text >> text >> text;
  for (int& steps : contacts) kept_rows >> steps >> text;
  EXPECT_EQ(contacts[0] + contacts[1] + contacts[2], 12) << "steps whose contacts were detected";
  EXPECT_GT(contacts[2], 0) << "the first detection finds its pairs itself";
  EXPECT_THAT(tables, HasSubstr("| n-body"));
  EXPECT_THAT(tables, HasSubstr("146K")) << "the paper's row";
}

TEST_F(BenchScenes, refuses_scenes_that_are_none) {
  const Result result = run("--scene bunny");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("there is no scene 'bunny'"));
}

}  // namespace
}  // namespace softcd::test
