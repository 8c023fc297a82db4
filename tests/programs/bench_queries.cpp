#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;

class BenchQueries : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_BENCH, "queries " + arguments, folder_); }

  TemporaryFolder folder_;
};

// Others answer the same questions: the program fails where they answer something else.
TEST_F(BenchQueries, rays_and_points_are_measured) {
  const Result result =
      run("--questions 1000 --repeat 1 --json " + folder_.file("json") + " --markdown " + folder_.file("table.md"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, folder_.read("table.md"));
  EXPECT_THAT(result.output, HasSubstr("1000 rays"));
  const nlohmann::json json = nlohmann::json::parse(folder_.read("json"));
  ASSERT_FALSE(json.at("rows").empty());
  EXPECT_EQ(json["rows"][0]["name"], "softcd, cpu");
  for (const auto& row : json["rows"]) {
    EXPECT_GT(row["triangles"], 90000) << row;
    EXPECT_EQ(row["rays"], 1000) << row;
    EXPECT_GT(row["ms"]["build"], 0) << row;
    EXPECT_GT(row["ms"]["rays"], 0) << row;
  }
}

TEST_F(BenchQueries, a_folder_without_meshes_is_wrong_input) {
  EXPECT_EQ(run("--step " + folder_.file("missing")).exit_code, 2);
}

}  // namespace
}  // namespace softcd::test
