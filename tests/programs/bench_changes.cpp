#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

TEST(BenchChanges, all_and_some_triangles_are_measured) {
  const TemporaryFolder folder;
  const Result result = run_program(
      SOFTCD_BENCH, "changes --repeat 1 --json " + folder.file("json") + " --markdown " + folder.file("table.md"),
      folder);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, folder.read("table.md"));
  const nlohmann::json json = nlohmann::json::parse(folder.read("json"));
  ASSERT_EQ(json.at("rows").size(), 4U);
  for (const auto& row : json["rows"]) {
    EXPECT_GT(row["ms"]["all"], 0) << row;
    EXPECT_GT(row["ms"]["changed"], 0) << row;
    EXPECT_LT(row["ratio"], 1) << row;
  }
}

}  // namespace
}  // namespace softcd::test
