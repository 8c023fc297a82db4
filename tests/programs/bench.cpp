#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// The vertices of the second triangle follow.
const std::string kTwoTriangles = "f 1 2 3\nf 4 5 6\nv 0 0 0\nv 4 0 0\nv 0 4 0\n";

class Bench : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_BENCH, arguments, folder_); }

  nlohmann::json rows(const std::string& arguments) const {
    const Result result = run("detector --backend cpu --repeat 1 " + arguments + " --json " + folder_.file("json"));
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, IsEmpty());
    return nlohmann::json::parse(folder_.read("json")).at("rows");
  }

  void expect_refused(const std::string& arguments, const std::string& problem) const {
    test::expect_refused(SOFTCD_BENCH, arguments, folder_, problem);
  }

  TemporaryFolder folder_;
};

TEST_F(Bench, every_scene_has_contacts_and_near_misses_in_both_modes) {
  std::set<std::string> seen;
  for (const auto& row : rows("--scale 0.1")) {
    seen.insert(row["scene"].get<std::string>() + " " + row["detection"].get<std::string>());
    for (const char* kind : {"vt", "ee"}) {
      const auto contacts = row[std::string(kind) + "_contacts"].get<std::uint64_t>();
      EXPECT_GT(contacts, 0u) << row;
      EXPECT_GT(row[std::string(kind) + "_candidates"].get<std::uint64_t>(), contacts) << row;
    }
    EXPECT_GT(row["ms"]["total"], 0) << row;
  }
  EXPECT_THAT(seen, testing::ElementsAre("cloth-on-ball ccd", "cloth-on-ball dcd", "funnel ccd", "funnel dcd",
                                         "n-body ccd", "n-body dcd"));
}

TEST_F(Bench, ways_to_the_same_contacts_find_the_same) {
  std::map<std::pair<std::string, std::string>, std::set<std::string>> checksums;
  std::size_t exact_and_uniform = 0, paper = 0;
  for (const auto& row : rows("--scale 0.05 --sweep stages,subdivision,cell_size_factor")) {
    if (row["broad_phase"] == "paper") {
      ++paper;
      continue;
    }
    ++exact_and_uniform;
    checksums[{row["scene"], row["detection"]}].insert(row["contacts_checksum"].get<std::string>());
  }
  // For three scenes and two modes: 1 of stages, 3 of subdivision, 9 cell sizes; 1 of subdivision, 7 cell sizes.
  EXPECT_EQ(exact_and_uniform, 6u * (1 + 3 + 9));
  EXPECT_EQ(paper, 6u * (1 + 7));
  EXPECT_EQ(checksums.size(), 6u);
  for (const auto& [scene_and_mode, found] : checksums) EXPECT_EQ(found.size(), 1u) << scene_and_mode.first;
}

TEST_F(Bench, large_triangles_are_split_among_balls) {
  for (const auto& row : rows("--scene n-body --scale 0.1")) EXPECT_GT(row["children"], 0) << row;
}

TEST_F(Bench, many_bodies_meet_seldom) {
  for (const auto& row : rows("--scene many-bodies --scale 0.1")) {
    EXPECT_EQ(row["triangles"], 1200) << row;
    EXPECT_GT(row["vt_contacts"], 0) << row;
    EXPECT_LT(row["vt_contacts"], 1200) << row;
  }
}

TEST_F(Bench, hopeless_measurements_are_left_out_and_said) {
  std::size_t left_out = 0;
  for (const auto& row : rows("--scene funnel --scale 0.05 --sweep subdivision --most-tests 1000")) {
    if (row.contains("left_out")) ++left_out;
  }
  EXPECT_EQ(left_out, 2u);
  EXPECT_THAT(folder_.read("output"), HasSubstr("would need more than 1e+03 tests"));
}

TEST_F(Bench, sizes_go_down_from_the_largest) {
  const nlohmann::json sizes = rows("--sweep scaling --most 40000");
  ASSERT_EQ(sizes.size(), 4u);
  EXPECT_NEAR(sizes[0]["triangles"].get<double>(), 40000, 2000);
  EXPECT_NEAR(sizes[2]["triangles"].get<double>(), 10000, 1000);
}

TEST_F(Bench, threads_go_up_to_all_that_there_are) {
  const nlohmann::json runs = rows("--scene funnel --scale 0.1 --sweep threads --backend cpu");
  ASSERT_GE(runs.size(), 2u);
  EXPECT_EQ(runs[0]["threads"], 1);
  for (const auto& run : runs) {
    EXPECT_LE(run["threads"].get<unsigned>(), std::max(1U, std::thread::hardware_concurrency())) << run;
    EXPECT_GT(run["vt_contacts"].get<int>() + run["ee_contacts"].get<int>(), 0) << run;
  }
}

TEST_F(Bench, markdown_is_what_is_printed) {
  const Result result = run("detector --scene funnel --scale 0.1 --repeat 1 --markdown " + folder_.file("tables.md"));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, folder_.read("tables.md"));
  EXPECT_THAT(result.output, HasSubstr("\n| funnel | dcd fast "));
  EXPECT_THAT(result.output, HasSubstr("\n|:-------|:------------|--"));
}

TEST_F(Bench, meshes_from_files_are_measured) {
  const std::string frames = "--t0 " + folder_.write("t0.obj", kTwoTriangles + "v 1 1 1\nv 1 1.5 8\nv 1.5 1 8\n") +
                             " --t1 " + folder_.write("t1.obj", kTwoTriangles + "v 1 1 -1\nv 1 1.5 8\nv 1.5 1 8\n");
  const nlohmann::json measured = rows(frames);
  ASSERT_EQ(measured.size(), 2u);
  EXPECT_EQ(measured[0]["vt_contacts"], 0);
  EXPECT_EQ(measured[1]["vt_contacts"], 1);
}

TEST_F(Bench, recorded_steps_are_measured_beside_generated_scenes) {
  for (const char* name : {"one", "other"}) {
    const std::string frames = std::string(name) + "/frames/";
    std::filesystem::create_directories(folder_.file(frames));
    // By their numbers, 9 is before 10.
    folder_.write(frames + "9.obj", kTwoTriangles + "v 1 1 1\nv 1 1.5 8\nv 1.5 1 8\n");
    folder_.write(frames + "10.obj", kTwoTriangles + "v 1 1 -1\nv 1 1.5 8\nv 1.5 1 8\n");
  }
  const nlohmann::json measured = rows("--scene funnel --scale 0.05 --step " + folder_.file("one") + " " +
                                       folder_.file("other/") + " --mode ccd-precise,ccd-conservative");
  std::vector<std::string> found;
  for (const auto& row : measured) {
    const auto text = [&row](const char* key) { return row[key].get<std::string>(); };
    found.push_back(text("scene") + " " + text("detection") + " " + text("accuracy"));
    if (row["scene"] == "funnel") continue;
    EXPECT_EQ(row["vt_contacts"], 1) << row;
    EXPECT_NEAR(row["earliest_toi"].get<double>(), 0.5, 1e-6) << row;
  }
  EXPECT_THAT(found, testing::ElementsAre("funnel ccd precise", "funnel ccd conservative", "one ccd precise",
                                          "one ccd conservative", "other ccd precise", "other ccd conservative"));
}

TEST_F(Bench, quartiles_are_around_the_median) {
  Result result = run("detector --backend cpu --scene funnel --scale 0.05 --repeat 6 --json " + folder_.file("json"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json json = nlohmann::json::parse(folder_.read("json"));
  for (const auto& row : json.at("rows")) {
    EXPECT_GT(row["total_ms_quartiles"]["first"], 0) << row;
    EXPECT_LE(row["total_ms_quartiles"]["first"], row["ms"]["total"]) << row;
    EXPECT_GE(row["total_ms_quartiles"]["third"], row["ms"]["total"]) << row;
  }
}

TEST_F(Bench, names_that_are_not_utf8_are_replaced_in_json) {
  run("detector --backend cpu --scene funnel --scale 0.05 --repeat 1 --machine 'a\xFF' --json " + folder_.file("json"));
  EXPECT_EQ(nlohmann::json::parse(folder_.read("json")).at("machine"), "a\xEF\xBF\xBD");
}

TEST_F(Bench, output_that_cannot_be_written_is_an_error) {
  for (const char* output : {" >/dev/full", " >&-"}) {
    const Result result =
        run_shell("('" SOFTCD_BENCH "' detector --backend cpu --scene funnel --scale 0.05 --repeat 1" +
                      (output + std::string(")")),
                  folder_);
    EXPECT_EQ(result.exit_code, 1) << output;
    EXPECT_THAT(result.errors, HasSubstr("softcd-bench: standard output cannot be written"));
  }
}

TEST_F(Bench, refuses_command_lines) {
  expect_refused("", "A subcommand is required");
  expect_refused("detector --scene bunny", "'bunny' is not one of funnel, cloth-on-ball, n-body, many-bodies");
  expect_refused("detector --sweep everything",
                 "'everything' is not one of stages, subdivision, cell_size_factor, scaling, threads");
  expect_refused("detector --backend gpu", "'gpu' is not one of auto, cpu, cuda");
  expect_refused("detector --repeat 0", "--repeat");
  expect_refused("detector --scale 0", "--scale");
  expect_refused("detector --t0 t0.obj", "--t0 requires --t1");
  expect_refused("detector --t0 absent.obj --t1 absent.obj", "absent.obj: cannot be opened");
  expect_refused("detector --mode dcd", "'dcd' is not one of dcd-fast, ccd-precise, ccd-conservative");
  expect_refused("detector --step " + folder_.file("absent"), "--step");
  expect_refused("detector --step " + std::filesystem::path(folder_.file("json")).parent_path().string(),
                 "frames: is not a folder of two meshes");
}

TEST_F(Bench, results_that_cannot_be_written_are_an_error) {
  for (const char* option : {" --markdown ", " --json "}) {
    const Result result =
        run("detector --scene funnel --scale 0.05 --repeat 1" + (option + folder_.file("absent/file")));
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.errors, HasSubstr("cannot be written"));
  }
}

}  // namespace
}  // namespace softcd::test
