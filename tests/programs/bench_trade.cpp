#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::size_t count_of(const nlohmann::json& row, const char* key) {
  return row.at(key).get<std::size_t>();
}

class BenchTrade : public testing::Test {
 protected:
  nlohmann::json measure(const std::string& arguments) const {
    const Result result = run_program(SOFTCD_BENCH,
                                      "trade --repeat 1 " + arguments + " --json " + folder_.file("json") + " --csv " +
                                          std::filesystem::path(folder_.file("json")).parent_path().string(),
                                      folder_);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, IsEmpty());
    return nlohmann::json::parse(folder_.read("json"));
  }

  /// Expects one line more than rows.
  void expect_csv(const std::string& name, const std::string& header, std::size_t rows) const {
    const std::string csv = folder_.read(name);
    EXPECT_THAT(csv, StartsWith(header + "\n"));
    EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), rows + 1);
  }

  TemporaryFolder folder_;
};

TEST_F(BenchTrade, queries_are_judged_in_every_mode) {
  const nlohmann::json measured = measure("--part queries --generated 800 --machine 'a machine'");
  EXPECT_EQ(measured["machine"], "a machine");
  for (const char* key : {"date", "compiler", "softcd"})
    EXPECT_THAT(measured[key].get<std::string>(), ::testing::SizeIs(testing::Gt(4U)));
  const nlohmann::json& rows = measured.at("queries");
  expect_csv("queries.csv",
             "set,kind,mode,margin,queries,touching,missed,false_alarms,early,early_median,early_999,early_max,late,"
             "late_median,late_999,late_max,ns_per_query",
             rows.size());
  std::map<std::string, std::set<std::size_t>> touching;
  std::map<std::string, std::size_t> missed;
  for (const auto& row : rows) {
    touching[row["set"].get<std::string>() + row["kind"].get<std::string>()].insert(count_of(row, "touching"));
    missed[row["mode"]] += count_of(row, "missed");
    EXPECT_EQ(count_of(row, "queries"), 800U);
    EXPECT_LE(count_of(row, "missed") + count_of(row, "early") + count_of(row, "late"), count_of(row, "touching"));
    EXPECT_LE(count_of(row, "touching") + count_of(row, "false_alarms"), count_of(row, "queries"));
    EXPECT_EQ(row["late_max"].is_null(), count_of(row, "late") == 0) << row;
    EXPECT_GT(row["ns_per_query"], 0);
    if (row["mode"] == "conservative" || row["mode"] == "precise") {
      EXPECT_EQ(count_of(row, "late"), 0U) << row;
    }
  }
  EXPECT_EQ(touching.size(), 4U);
  for (const auto& [set, counts] : touching) {
    EXPECT_EQ(counts.size(), 1U) << "every mode is judged by the same contacts: " << set;
    EXPECT_GT(*counts.begin(), 0U) << set;
  }
  EXPECT_EQ(missed.at("conservative"), 0U);
  EXPECT_EQ(missed.at("precise"), 0U);
  EXPECT_GT(missed.at("dcd-1"), 0U);
  EXPECT_GT(missed.at("dcd-1"), missed.at("dcd-16"));
}

TEST_F(BenchTrade, recorded_queries_are_read) {
  const std::filesystem::path folder = folder_.file("queries");
  std::filesystem::create_directories(folder / "falling" / "vertex-face");
  // A vertex from height 1 to -1, over a triangle and beside it.
  std::string csv;
  for (const char* x : {"1,4", "3,4"}) {
    for (const char* z : {"1,1", "-1,1"}) {
      csv += std::string(x) + ",1,2," + z + ",1\n0,1,0,1,0,1,1\n1,1,0,1,0,1,1\n0,1,1,1,0,1,1\n";
    }
  }
  folder_.write("queries/falling/vertex-face/data.csv", csv);
  const nlohmann::json rows = measure("--part queries --generated 10 --queries " + folder.string()).at("queries");
  std::size_t found = 0;
  for (const auto& row : rows) {
    if (row["set"] != "falling") continue;
    ++found;
    EXPECT_EQ(count_of(row, "queries"), 2U);
    EXPECT_EQ(count_of(row, "touching"), 1U);
    if (row["mode"] == "conservative") {
      EXPECT_EQ(count_of(row, "missed") + count_of(row, "false_alarms"), 0U);
    }
  }
  EXPECT_GE(found, 8U);
}

TEST_F(BenchTrade, steps_are_judged_in_every_mode) {
  const nlohmann::json rows = measure("--part steps --scale 0.02").at("steps");
  expect_csv("steps.csv",
             "scene,features,mode,backend,triangles,margin,candidates,touching,contacts,missed,extra,unsettled,ms,"
             "transfer_ms",
             rows.size());
  EXPECT_EQ(rows.size(), 3U * 2 * 8);
  EXPECT_THAT(folder_.read("steps.csv"), HasSubstr("\nfunnel,\"vt,ee\",conservative,cpu,"));
  std::map<std::string, std::size_t> missed;
  for (const auto& row : rows) {
    missed[row["mode"]] += count_of(row, "missed");
    EXPECT_EQ(count_of(row, "touching") - count_of(row, "missed") + count_of(row, "extra"), count_of(row, "contacts"));
    EXPECT_GT(count_of(row, "touching"), 0U) << row;
    EXPECT_GT(row["ms"], 0);
  }
  EXPECT_EQ(missed.at("conservative"), 0U);
  EXPECT_EQ(missed.at("precise"), 0U);
  EXPECT_GT(missed.at("dcd-1"), 0U);
}

TEST_F(BenchTrade, markdown_is_what_is_printed) {
  const Result result = run_program(
      SOFTCD_BENCH, "trade --part queries --generated 10 --repeat 1 --markdown " + folder_.file("tables.md"), folder_);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, folder_.read("tables.md"));
  EXPECT_THAT(result.output, HasSubstr("### Single queries"));
}

TEST_F(BenchTrade, figures_are_drawn_from_the_results) {
  if (run_program("python3", "-c 'import matplotlib'", folder_).exit_code != 0)
    GTEST_SKIP() << "python3 has no matplotlib: apt-get install python3-matplotlib";
  measure("--part queries,steps --generated 2500 --scale 0.02");
  const auto draw = [&](const std::string& results) {
    return run_program("python3", SOFTCD_REPORT + (" --out " + folder_.file("figures ")) + results, folder_);
  };
  for (const std::string& results : {folder_.file("json --figure trade-queries"), folder_.file("steps.csv")}) {
    const Result result = draw(results);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
  }
  for (const char* figure : {"trade-queries", "trade-steps"}) {
    EXPECT_THAT(folder_.read(std::string("figures/") + figure + ".svg"), HasSubstr("dcd-16")) << figure;
  }
  EXPECT_NE(draw(folder_.write("empty.json", "{}")).exit_code, 0);
}

TEST_F(BenchTrade, refuses_command_lines) {
  const auto expect_refused = [this](const std::string& arguments, const std::string& problem) {
    test::expect_refused(SOFTCD_BENCH, "trade " + arguments, folder_, problem);
  };
  expect_refused("--part everything", "'everything' is not one of queries, steps, simulation");
  expect_refused("--queries absent", "--queries");
  expect_refused("--steps absent", "--steps");
  expect_refused("--csv absent", "--csv");
  expect_refused("--generated 0", "--generated");
  expect_refused("--runs 0", "--runs");
}

}  // namespace
}  // namespace softcd::test
