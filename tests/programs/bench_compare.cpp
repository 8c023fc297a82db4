#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kNoLoss = 0, kFailure = 1, kRefused = 2, kLoss = 3;

/// Returns a row of a file of results: `ms` in all, half of it for the tests.
json row(const std::string& scene, double ms) {
  json result = {{"sweep", "stages"},
                 {"scene", scene},
                 {"backend", "cpu"},
                 {"detection", "ccd"},
                 {"accuracy", "precise"},
                 {"broad_phase", "exact"},
                 {"subdivision", true},
                 {"cell_size_factor", 0.0},
                 {"threads", 2},
                 {"repetitions", 5},
                 {"triangles", 1000},
                 {"contacts_checksum", "0123456789abcdef"},
                 {"peak_bytes", 100000000},
                 {"total_ms_quartiles", {{"first", ms}, {"third", ms}}}};
  for (const char* count :
       {"split_triangles", "children", "big_triangles", "entries", "cells", "tests", "triangle_pairs", "flagged_pairs",
        "vt_candidates", "ee_candidates", "vt_contacts", "ee_contacts"}) {
    result[count] = 7;
  }
  for (const char* stage : {"volumes", "subdivision", "assignment", "sort", "features", "narrow", "transfer"}) {
    result["ms"][stage] = 0.5;
  }
  result["ms"]["total"] = ms;
  result["ms"]["tests"] = ms / 2;
  return result;
}

using Rows = std::vector<json>;

json results(const Rows& rows) {
  return {{"benchmark", "detector"},
          {"machine", "a machine"},
          {"date", "2026-01-02"},
          {"compiler", "g++ 12"},
          {"rows", rows}};
}

class BenchCompare : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_BENCH, "compare " + arguments, folder_); }

  Result compare(const Rows& old_rows, const Rows& new_rows, const std::string& options = "") const {
    return run(write(old_rows, "old.json") + " " + write(new_rows, "new.json") + " " + options);
  }

  std::string write(const Rows& rows, const std::string& name) const {
    return folder_.write(name, results(rows).dump());
  }

  /// Writes a program softcd-bench whose n-th run returns the n-th of `all_rows`, and logs that it ran.
  std::string write_build(const std::string& name, const std::vector<Rows>& all_rows) const {
    for (std::size_t i = 0; i < all_rows.size(); ++i) write(all_rows[i], name + std::to_string(i + 1));
    std::string file =
        folder_.write(name, "#!/bin/sh\ncd " + folder_.file("") + "\necho \"" + name + " $*\" >>log\n" +
                                "for last; do :; done\ncp " + name + "$(grep -c '^" + name + " ' log) \"$last\"\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file;
  }

  TemporaryFolder folder_;
};

TEST_F(BenchCompare, equal_results_are_no_loss) {
  const Result result = compare({row("funnel", 10), row("ball", 3)}, {row("funnel", 10), row("ball", 3)});
  EXPECT_EQ(result.exit_code, kNoLoss) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("no loss: of 2 rows 0 slower"), HasSubstr("new/old on average 1.000")));
  EXPECT_THAT(result.output, AllOf(HasSubstr("a machine, 2026-01-02, g++ 12"), Not(HasSubstr("Stages"))));
}

TEST_F(BenchCompare, a_row_that_is_slower_is_a_loss_and_its_stages_are_told) {
  const Result result = compare({row("funnel", 10), row("ball", 3)}, {row("funnel", 10.6), row("ball", 3)});
  EXPECT_EQ(result.exit_code, kLoss);
  EXPECT_THAT(result.output, ContainsRegex("\\| funnel .* 10.000 .* 10.600 .* 1.060 .* 5.0 % .* SLOWER "));
  EXPECT_THAT(result.output, ContainsRegex("\\| ball .* same "));
  EXPECT_THAT(result.output, HasSubstr("\nTolerance: 5 %, or"));
  EXPECT_THAT(result.output, ContainsRegex("\\| funnel [^\n]* tests +\\| +5.000 \\| +5.300 \\| +1.06 "));
  EXPECT_THAT(result.output, HasSubstr("LOSS: of 2 rows 1 slower"));
}

TEST_F(BenchCompare, what_is_faster_or_within_the_tolerance_is_no_loss) {
  EXPECT_EQ(compare({row("funnel", 10)}, {row("funnel", 10.4)}).exit_code, kNoLoss);
  EXPECT_EQ(compare({row("funnel", 10)}, {row("funnel", 10.4)}, "--tolerance 3").exit_code, kLoss);
  EXPECT_EQ(compare({row("funnel", 10)}, {row("funnel", 14)}, "--tolerance 50").exit_code, kNoLoss);
  const Result faster = compare({row("funnel", 10)}, {row("funnel", 8)});
  EXPECT_EQ(faster.exit_code, kNoLoss);
  EXPECT_THAT(faster.output, AllOf(HasSubstr("faster |\n"), HasSubstr("1 faster")));
}

TEST_F(BenchCompare, the_tolerance_is_never_below_the_distance_of_quartiles) {
  json noisy = row("funnel", 10);
  noisy["total_ms_quartiles"] = {{"first", 9}, {"third", 12}};
  for (const bool old_is_noisy : {true, false}) {
    const auto exit_code = [&](double new_ms) {
      json after = row("funnel", new_ms);
      if (!old_is_noisy) after["total_ms_quartiles"] = {{"first", 0.9 * new_ms}, {"third", 1.2 * new_ms}};
      return compare({old_is_noisy ? noisy : row("funnel", 10)}, {after}).exit_code;
    };
    EXPECT_EQ(exit_code(12.9), kNoLoss) << old_is_noisy;
    EXPECT_EQ(exit_code(13.1), kLoss) << old_is_noisy;
  }
  EXPECT_THAT(folder_.read("output"), HasSubstr(" 30.0 % "));
}

TEST_F(BenchCompare, more_memory_is_a_loss) {
  json after = row("funnel", 10);
  after["peak_bytes"] = 104000000;
  EXPECT_EQ(compare({row("funnel", 10)}, {after}).exit_code, kNoLoss);
  after["peak_bytes"] = 106000000;
  const Result result = compare({row("funnel", 10)}, {after});
  EXPECT_EQ(result.exit_code, kLoss);
  EXPECT_THAT(result.output, ContainsRegex("100.0 \\| +106.0 \\| MORE MEMORY "));
}

TEST_F(BenchCompare, other_contacts_and_counts_are_told_as_such) {
  json after = row("funnel", 10);
  after["contacts_checksum"] = "fedcba9876543210";
  after["vt_contacts"] = 8;
  json more_tests = row("ball", 10);
  more_tests["tests"] = 9;
  const Result result = compare({row("funnel", 10), row("ball", 10)}, {after, more_tests});
  EXPECT_EQ(result.exit_code, kNoLoss);
  EXPECT_THAT(result.output,
              HasSubstr("\nfunnel of 1000 triangles, cpu, ccd precise: OTHER CONTACTS, vt_contacts 7 -> 8\n"));
  EXPECT_THAT(result.output,
              HasSubstr("\nball of 1000 triangles, cpu, ccd precise: the same contacts, tests 7 -> 9\n"));
  EXPECT_THAT(result.output, HasSubstr("1 with other contacts"));
}

TEST_F(BenchCompare, rows_are_matched_by_every_setting_and_those_of_one_file_are_named) {
  const json base = row("funnel", 10);
  for (const auto& [key, value] : std::vector<std::pair<std::string, json>>{{"scene", "ball"},
                                                                            {"triangles", 2000},
                                                                            {"backend", "cuda"},
                                                                            {"detection", "dcd"},
                                                                            {"accuracy", "fast"},
                                                                            {"sweep", "cell_size_factor"},
                                                                            {"broad_phase", "uniform"},
                                                                            {"subdivision", false},
                                                                            {"cell_size_factor", 1.2}}) {
    json other = row("funnel", 90);
    other[key] = value;
    const Result result = compare({base}, {other, base});
    EXPECT_EQ(result.exit_code, kNoLoss) << key;
    EXPECT_THAT(result.output, AllOf(HasSubstr("of 1 rows"), HasSubstr("\nOnly in new: "))) << key;
    EXPECT_THAT(compare({other, base}, {base}).output, HasSubstr("\nOnly in old: ")) << key;
  }
  json one_thread = row("funnel", 10), two_threads = row("funnel", 6);
  one_thread["sweep"] = two_threads["sweep"] = "threads";
  one_thread["threads"] = 1;
  EXPECT_THAT(compare({one_thread, two_threads}, {two_threads, one_thread}).output, HasSubstr("no loss: of 2 rows"));
}

TEST_F(BenchCompare, results_that_call_the_cell_size_factor_lambda_are_read) {
  json with_new_name = row("funnel", 10);
  with_new_name["sweep"] = "cell_size_factor";
  with_new_name["cell_size_factor"] = 1.2;
  json with_old_name = with_new_name;
  with_old_name.erase("cell_size_factor");
  with_old_name["sweep"] = "lambda";
  with_old_name["lambda"] = 1.2;
  const Result result = compare({with_old_name}, {with_new_name});
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("no loss: of 1 rows"), HasSubstr("cell_size_factor, 1.2"), Not(HasSubstr("Only in"))));
  with_old_name["lambda"] = 2.4;
  EXPECT_THAT(compare({with_old_name}, {with_new_name}).errors, HasSubstr("there is nothing to compare"));
}

TEST_F(BenchCompare, what_is_not_measured_any_more_is_a_loss) {
  json left_out = row("funnel", 10);
  for (const char* key : {"ms", "peak_bytes", "contacts_checksum", "tests", "total_ms_quartiles"}) left_out.erase(key);
  left_out["left_out"] = "out of memory";
  const Result result = compare({row("funnel", 10)}, {left_out});
  EXPECT_EQ(result.exit_code, kLoss);
  EXPECT_THAT(result.output, HasSubstr("| NOT MEASURED: out of memory "));
  EXPECT_EQ(compare({left_out}, {row("funnel", 10)}).exit_code, kNoLoss);
  EXPECT_EQ(compare({left_out}, {left_out}).exit_code, kNoLoss);
}

TEST_F(BenchCompare, what_cannot_be_compared_is_an_error) {
  const std::string good = write({row("funnel", 10)}, "good.json");
  const auto expect_failure = [&](const std::string& other, const std::string& problem) {
    const Result result = run(good + " " + other);
    EXPECT_EQ(result.exit_code, kFailure);
    EXPECT_THAT(result.errors, HasSubstr(problem));
    EXPECT_THAT(result.output, IsEmpty());
  };
  expect_failure(write({row("ball", 10)}, "ball.json"), "no row is in both");
  expect_failure(write({row("funnel", 10), row("funnel", 10)}, "twice.json"), "two rows are of funnel 1000 cpu");
  expect_failure(folder_.write("no.json", "{"), "no.json: is no result of softcd-bench detector --json");
  expect_failure(folder_.write("bullet.json", R"({"benchmark": "bullet"})"), "it is of another benchmark");
  expect_failure(folder_.file("absent.json"), "absent.json: is no result");
}

TEST_F(BenchCompare, builds_are_run_in_turn_and_compared_by_medians_of_rounds) {
  const std::string old_build = write_build("old", {{row("funnel", 10)}, {row("funnel", 10.2)}, {row("funnel", 10.1)}});
  const std::string new_build =
      write_build("new", {{row("funnel", 11.5)}, {row("funnel", 11.7)}, {row("funnel", 10.9)}});
  const std::string arguments = "--builds " + old_build + " " + new_build + " --rounds 3 -- --scene funnel --repeat 9";
  const Result result = run(arguments);
  EXPECT_EQ(result.exit_code, kLoss) << result.errors;
  // The new build's rounds are 0.8 apart.
  EXPECT_THAT(result.output, ContainsRegex("\\| funnel .* 10.100 .* 11.500 .* 1.139 .* 7.0 % .* SLOWER "));
  EXPECT_THAT(folder_.read("log"), ContainsRegex("^old detector --scene funnel --repeat 9 --json [^\n]*\n"
                                                 "new detector --scene funnel --repeat 9 --json [^\n]*\n"
                                                 "old [^\n]*\nnew [^\n]*\nold [^\n]*\nnew [^\n]*\n$"));
}

TEST_F(BenchCompare, losses_smaller_than_what_rounds_vary_by_are_no_losses) {
  const std::string old_build = write_build("old", {{row("funnel", 10)}, {row("funnel", 13)}});
  const std::string new_build = write_build("new", {{row("funnel", 14)}, {row("funnel", 14)}});
  const Result result = run("--rounds 2 --builds " + old_build + " " + new_build);
  EXPECT_EQ(result.exit_code, kNoLoss) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr(" 1.217 "), HasSubstr(" 26.1 % ")));
}

TEST_F(BenchCompare, a_round_that_was_disturbed_hides_no_loss) {
  std::vector<Rows> old_rounds(7, {row("funnel", 10)}), new_rounds(7, {row("funnel", 11)});
  old_rounds[2] = {row("funnel", 30)};
  new_rounds[5] = {row("funnel", 5)};
  const Result result = run("--builds " + write_build("old", old_rounds) + " " + write_build("new", new_rounds));
  EXPECT_EQ(result.exit_code, kLoss) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr(" 1.100 "), HasSubstr(" 5.0 % ")));
}

TEST_F(BenchCompare, builds_that_fail_or_contradict_themselves_are_an_error) {
  const std::string good = write_build("good", {3, {row("funnel", 10)}});
  const std::string failing = folder_.write("failing", "#!/bin/sh\nexit 1\n");
  std::filesystem::permissions(failing, std::filesystem::perms::owner_all);
  Result result = run("--rounds 2 --builds " + good + " " + failing);
  EXPECT_EQ(result.exit_code, kFailure);
  EXPECT_THAT(result.errors, HasSubstr("this failed: " + failing + " detector --json"));

  json other = row("funnel", 10);
  other["contacts_checksum"] = "fedcba9876543210";
  const std::string fickle = write_build("fickle", {{row("funnel", 10)}, {other}});
  result = run("--rounds 2 --builds " + good + " " + fickle);
  EXPECT_EQ(result.exit_code, kFailure);
  EXPECT_THAT(result.errors, HasSubstr("two runs of one build did not measure or find the same"));
}

TEST_F(BenchCompare, this_build_is_not_slower_than_itself) {
  const Result result = run("--rounds 2 --tolerance 10000 --builds '" SOFTCD_BENCH "' '" SOFTCD_BENCH
                            "' -- --scene funnel --scale 0.05 --backend cpu --repeat 1");
  EXPECT_EQ(result.exit_code, kNoLoss) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("no loss: of 2 rows"), Not(HasSubstr("contacts,"))));
}

TEST_F(BenchCompare, refuses_command_lines) {
  for (const char* arguments : {"", "one.json", "one.json two.json three.json", "--builds one", "--rounds 1 a b",
                                "--tolerance -1 a b", "--builds absent absent"}) {
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, kRefused) << arguments;
    EXPECT_THAT(result.output, IsEmpty()) << arguments;
  }
}

}  // namespace
}  // namespace softcd::test
