#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

TEST(BenchTradeSimulation, bullet_tunnels_where_softcd_does_not) {
  const TemporaryFolder folder;
  const Result result = run_program(
      SOFTCD_BENCH,
      "trade --part simulation --runs 1 --nodes 8 --seconds 0.05 --world soft,deformable --json " + folder.file("json"),
      folder);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  std::set<std::string> scenes, knobs, worlds;
  std::size_t of_bullet = 0;
  const nlohmann::json measured = nlohmann::json::parse(folder.read("json"));
  for (const auto& row : measured.at("simulation")) {
    scenes.insert(row["scene"]);
    knobs.insert(row["knob"]);
    worlds.insert(row["world"]);
    EXPECT_GT(row["ms_per_second"], 0) << row;
    EXPECT_GE(row["crossings"], row["tunnelled"]) << row;
    EXPECT_GE(row["most_penetrating"], row["penetrating"]) << row;
    if (row["scene"] != "throw") continue;
    EXPECT_GT(row["energy_start"], 0) << row;
    if (row["detection"] == "ccd") {
      EXPECT_EQ(row["crossings"], 0) << row;
    }
    if (row["detection"] == "bullet") of_bullet += row["tunnelled"].get<std::size_t>();
  }
  EXPECT_GT(of_bullet, 0U);
  EXPECT_EQ(worlds, (std::set<std::string>{"deformable", "soft"}));
  EXPECT_EQ(scenes, (std::set<std::string>{"cloth-on-ball", "folded", "throw", "two-cloths"}));
  EXPECT_EQ(knobs,
            (std::set<std::string>{"accuracy", "contacts", "iterations", "cell size factor", "margin", "time step"}));
}

}  // namespace
}  // namespace softcd::test
