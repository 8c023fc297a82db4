#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

class BenchScaling : public testing::Test {
 protected:
  Result run(const std::string& arguments) const {
    return run_program(SOFTCD_BENCH, "scaling --backend cpu --repeat 1 " + arguments, folder_);
  }

  TemporaryFolder folder_;
};

// The program fails where several ranks find other contacts than one rank.
TEST_F(BenchScaling, ranks_find_what_one_finds) {
  const Result result = run("--gpus 1,3 --triangles 6000 --json " + folder_.file("json"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json json = nlohmann::json::parse(folder_.read("json"));
  ASSERT_EQ(json.at("rows").size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const nlohmann::json& row = json["rows"][i];
    EXPECT_EQ(row["ranks"], i % 2 == 0 ? 1 : 3) << row;
    EXPECT_GT(row["contacts"], 100) << row;
    EXPECT_EQ(row["contacts_checksum"], json["rows"][i - i % 2]["contacts_checksum"]) << row;
    EXPECT_GT(row["wait_ms"], 0) << row;
    EXPECT_LE(row["least_work_ms"], row["most_work_ms"]) << row;
    EXPECT_GT(row["ms"]["tests"], 0) << row;
  }
}

TEST_F(BenchScaling, weak_scaling_grows_the_scene_with_the_ranks) {
  const Result result = run("--weak --gpus 1,2 --triangles 6000 --mode dcd-fast --json " + folder_.file("json"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json rows = nlohmann::json::parse(folder_.read("json")).at("rows");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_NEAR(rows[1]["triangles"].get<double>() / rows[0]["triangles"].get<double>(), 2.0, 0.1);
}

}  // namespace
}  // namespace softcd::test
