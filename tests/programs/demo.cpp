#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "mesh_tools/mesh_io.hpp"
#include "run_program.hpp"
#include "softcd/fields/settings.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// Sets PATH for the lifetime of this object.
class SearchPath {
 public:
  explicit SearchPath(const std::string& path) : original_(std::getenv("PATH")) { setenv("PATH", path.c_str(), 1); }
  SearchPath(const SearchPath&) = delete;
  SearchPath& operator=(const SearchPath&) = delete;
  ~SearchPath() { setenv("PATH", original_.c_str(), 1); }

 private:
  std::string original_;
};

class Demo : public testing::Test {
 protected:
  /// Whether this build of the demo can draw pictures.
  static constexpr bool kDraws = SOFTCD_DEMO_DRAWS;

  /// Runs a small and quick simulation on the CPU.
  Result run(const std::string& arguments) const {
    const std::string picture = kDraws ? " --picture " + folder_.file("picture.png") : "";
    return run_program(SOFTCD_DEMO, arguments + " --backend cpu --steps 8 --picture-size 64x40" + picture, folder_);
  }

  void run_well(const std::string& arguments) const {
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, IsEmpty());
  }

  bool has(const std::string& name) const { return std::filesystem::exists(folder_.file(name)); }

  TemporaryFolder folder_;
};

TEST_F(Demo, lists_scenes_with_sizes_and_pictures) {
  const Result result = run_program(SOFTCD_DEMO, "--list", folder_);
  EXPECT_EQ(result.exit_code, 0);
  for (const char* name : {"cloth-on-ball", "funnel", "flamenco", "n-body", "mixed-sizes-cloth", "mixed-sizes-balls"}) {
    EXPECT_THAT(result.output, HasSubstr(fmt::format("picture docs/pictures/{}.png", name)));
  }
  EXPECT_THAT(result.output, HasSubstr("default size 60 nodes a side = 13924 triangles"));
  EXPECT_THAT(result.output, HasSubstr("--size paper 455 balls = 145936 triangles"));
}

TEST_F(Demo, every_setting_has_a_flag_but_for_the_read_out) {
  run_well("--help");
  const std::string help = folder_.read("output");
  for_each_field<bullet::Settings>([&](auto field) {
    std::string flag = field.kName;
    std::replace(flag.begin(), flag.end(), '_', '-');
    const bool has_flag = help.find("--" + flag + " ") != std::string::npos;
    const bool is_value = field.kHelp != nullptr;
    EXPECT_EQ(has_flag, is_value && flag != "read-out") << flag;
  });
}

TEST_F(Demo, runs_in_both_worlds) {
  for (const std::string world : {"soft", "deformable"}) {
    run_well("two-cloths --size 12 --world " + world + " --json " + folder_.file("json"));
    const auto json = nlohmann::json::parse(folder_.read("json"));
    EXPECT_EQ(json.at("world"), world);
    EXPECT_EQ(json.at("triangles"), 484);
    EXPECT_EQ(json.at("most_penetrating_vertices"), 0);
    EXPECT_EQ(json.at("most_intersecting_edges"), 0);
    EXPECT_GT(json.at("contacts_seconds"), 0);
    EXPECT_GT(json.at("crossings_seconds"), 0);
    EXPECT_LT(json.at("contacts_seconds").get<double>() + json.at("crossings_seconds").get<double>(),
              json.at("total_seconds").get<double>());
    EXPECT_THAT(folder_.read("output"), HasSubstr("softcd: preventing what would pass through"));
  }
  EXPECT_EQ(has("picture.png"), kDraws);
}

TEST_F(Demo, does_not_attribute_bullets_own_time_to_softcd) {
  run_well("two-cloths --size 12 --collision bullet --json " + folder_.file("json"));
  EXPECT_THAT(folder_.read("output"), Not(HasSubstr("softcd:")));
  EXPECT_EQ(nlohmann::json::parse(folder_.read("json")).at("rows")[0].count("detection_ms"), 0U);
}

TEST_F(Demo, exports_meshes_that_can_be_read_back) {
  run_well("two-cloths --size 12 --export " + folder_.file("meshes"));
  const mesh_tools::Mesh first = mesh_tools::read_mesh(folder_.file("meshes/frame-0000.ply"));
  const mesh_tools::Mesh second = mesh_tools::read_mesh(folder_.file("meshes/frame-0001.ply"));
  EXPECT_FALSE(has("meshes/frame-0002.ply"));
  EXPECT_EQ(first.positions.size(), 2 * 144U);
  EXPECT_EQ(first.triangles.size(), 484U);
  EXPECT_NO_THROW(mesh_tools::require_same_topology(first, "first", second, "second"));
  // The lower cloth is held at its first corner, (-3, 3, -3); the upper one falls.
  EXPECT_EQ(first.positions[0].x, -3);
  EXPECT_EQ(first.positions[0].y, 3);
  EXPECT_EQ(second.positions[0].y, 3);
  EXPECT_LT(second.positions[144 + 6 * 12 + 6].y, first.positions[144 + 6 * 12 + 6].y);
}

TEST_F(Demo, exports_what_the_name_ends_in) {
  run_well("two-cloths --size 12 --frame-steps 8 --export " + folder_.file("frame-#.stl"));
  EXPECT_EQ(folder_.read("frame-0.stl").size(), 84 + 50 * 484U);
  run_well("two-cloths --size 12 --frame-steps 8 --export " + folder_.file("frame-#.glb"));
  EXPECT_THAT(folder_.read("frame-0.glb"), StartsWith("glTF"));
}

TEST_F(Demo, exports_one_step_as_two_frames) {
  for (const std::string world : {"soft", "deformable"}) {
    run_well("two-cloths --size 12 --frame-steps 1 --world " + world + " --export " + folder_.file("meshes") +
             " --export-step 4 " + folder_.file(world));
    EXPECT_EQ(folder_.read(world + "/t0.ply"), folder_.read("meshes/frame-0002.ply"));
    EXPECT_EQ(folder_.read(world + "/t1.ply"), folder_.read("meshes/frame-0003.ply"));
    EXPECT_NE(folder_.read(world + "/t0.ply"), folder_.read(world + "/t1.ply"));
  }
}

TEST_F(Demo, exports_the_first_step) {
  run_well("two-cloths --size 12 --frame-steps 1 --export " + folder_.file("meshes") + " --export-step 1 " +
           folder_.file("step"));
  const mesh_tools::Mesh t0 = mesh_tools::read_mesh(folder_.file("step/t0.ply"));
  EXPECT_EQ(t0.positions[0].y, 3);
  EXPECT_EQ(folder_.read("step/t1.ply"), folder_.read("meshes/frame-0000.ply"));
}

TEST_F(Demo, numbers_frames_as_the_pattern_says) {
  const std::string record = kDraws ? " --record " + folder_.file("pictures") : "";
  run_well("two-cloths --size 12 --frame-steps 8 --export " + folder_.file("new/cloth-##.ply") + record);
  EXPECT_TRUE(has("new/cloth-00.ply"));
  EXPECT_FALSE(has("new/cloth-01.ply"));
  EXPECT_EQ(has("pictures/frame-0000.png"), kDraws);
}

// Replaces ffmpeg by a script that keeps its input.
TEST_F(Demo, hands_frames_to_ffmpeg) {
  if (!kDraws) GTEST_SKIP() << "the demo was built without OpenGL";
  folder_.write("ffmpeg", "#!/bin/sh\necho \"$@\" >\"" + folder_.file("arguments") + "\"\ncat >\"" +
                              folder_.file("frames") + "\"\n");
  std::filesystem::permissions(folder_.file("ffmpeg"), std::filesystem::perms::owner_all);
  const SearchPath path(folder_.file("") + ":" + std::getenv("PATH"));
  run_well("two-cloths --size 12 --record \"" + folder_.file("it's.mp4") + "\"");
  EXPECT_THAT(folder_.read("arguments"), HasSubstr("-video_size 64x40 -framerate 30"));
  EXPECT_THAT(folder_.read("arguments"), HasSubstr("file:" + folder_.file("it's.mp4")));
  EXPECT_EQ(folder_.read("frames").size(), 2U * 64 * 40 * 3);

  folder_.write("ffmpeg", "#!/bin/sh\nexit 3\n");
  const Result result = run("two-cloths --size 12 --record " + folder_.file("video.mp4"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("ffmpeg"));
}

TEST_F(Demo, says_that_ffmpeg_is_missing) {
  if (!kDraws) GTEST_SKIP() << "the demo was built without OpenGL";
  const SearchPath path(folder_.file(""));
  const Result result = run("two-cloths --size 12 --record " + folder_.file("video.mp4"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("ffmpeg, which is not installed"));
  EXPECT_THAT(result.output, IsEmpty());
}

// EGL gets a list without drivers.
TEST_F(Demo, simulates_where_no_picture_can_be_drawn) {
  const std::string without = "cd '" + folder_.file("") +
                              "' && __EGL_VENDOR_LIBRARY_FILENAMES=/dev/null '" SOFTCD_DEMO
                              "' two-cloths --size 8 --backend cpu --steps 2 ";
  const Result result = run_shell(without, folder_);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("2 steps in"));
  EXPECT_THAT(result.output, HasSubstr("no pictures can be drawn: "));
  EXPECT_FALSE(has("softcd-demo.png"));
  for (const char* asked_for : {"--picture a.png", "--record frames"}) {
    const Result refused = run_shell(without + asked_for, folder_);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.output, IsEmpty());
    EXPECT_THAT(refused.errors, HasSubstr("no pictures can be drawn: "));
  }
}

// `script` gives the program a terminal.
TEST_F(Demo, tells_people_at_a_terminal_how_long_it_takes) {
  const std::string picture = kDraws ? " --picture " + folder_.file("picture.png") : "";
  const Result result =
      run_shell("script -qec \"'" SOFTCD_DEMO "' two-cloths --size 8 --backend cpu --steps 3 --picture-size 64x40" +
                    picture + "\" /dev/null",
                folder_);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("step 1 of 3, "));
  EXPECT_THAT(result.output, HasSubstr("step 3 of 3, 0 s left"));
}

TEST_F(Demo, refuses_command_lines) {
  const auto expect_refused = [this](const std::string& arguments, const std::string& problem) {
    test::expect_refused(SOFTCD_DEMO, arguments, folder_, problem);
  };
  expect_refused("teapot", "there is no scene 'teapot'; see --list");
  expect_refused("cloth-on-bal", "there is no scene 'cloth-on-bal'; is 'cloth-on-ball' meant?; see --list");
  expect_refused("two-cloths --preset quick", "'quick' is not one of fast, balanced, safe");
  expect_refused("two-cloths --iterations 0", "--iterations");
  expect_refused("two-cloths --world rigid", "'rigid' is not one of soft, deformable");
  expect_refused("mixed-sizes-balls --world deformable", "mixed-sizes-balls runs in Bullet's classic soft world only");
  expect_refused("two-cloths --size 7", "'7' is neither 'paper' nor a number of nodes a side from 8 to");
  expect_refused("two-cloths --size large", "'large' is neither 'paper' nor a number");
  expect_refused("two-cloths --size paper", "two-cloths is not in the paper");
  expect_refused("two-cloths --edge-contacts all", "'all' is not one of off, report, respond, auto");
  expect_refused("two-cloths --frame-steps 0", "--frame-steps");
  expect_refused("two-cloths --picture-size 640", "'640' is not WIDTHxHEIGHT with numbers from 16 to 8192");
  expect_refused("two-cloths --picture-size 640x", "'640x' is not WIDTHxHEIGHT");
  expect_refused("two-cloths --picture-size 8x8193", "'8x8193' is not WIDTHxHEIGHT");
  expect_refused("two-cloths --overlays wire,cells", "cells, children and picked-cell need --view");
  expect_refused("two-cloths --steps 8 --export-step 9 folder", "9 is not a step from 1 to 8");
  expect_refused("two-cloths --export-step 0 folder", "0 is not a step from 1 to");
  expect_refused("two-cloths --export-step 5", "--export-step");
  expect_refused("two-cloths --export frame-##.obj", "'frame-##.obj' ends in none of .ply, .stl, .glb");
}

}  // namespace
}  // namespace softcd::test
