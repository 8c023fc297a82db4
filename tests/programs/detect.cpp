#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "brute_force.hpp"
#include "ground_truth.hpp"
#include "recorded_steps.hpp"
#include "run_program.hpp"
#include "softcd/fields/options.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A row of the contacts' file.
struct Row {
  std::string features;  ///< the first six columns
  float time_of_impact;
  float distance;

  friend bool operator==(const Row&, const Row&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Row& row) {
    return out << row.features << ' ' << row.time_of_impact << ' ' << row.distance;
  }
};

Row parse_row(const std::string& text) {
  const std::size_t distance = text.rfind(',');
  const std::size_t time = text.rfind(',', distance - 1);
  return {text.substr(0, time), std::stof(text.substr(time + 1)), std::stof(text.substr(distance + 1))};
}

// The meshes' coordinates are small integers, so results are exact up to a few roundings.
MATCHER_P3(is_contact, features, time_of_impact, distance, "") {
  return arg.features == features && std::abs(arg.time_of_impact - time_of_impact) < 1e-6F &&
         std::abs(arg.distance - distance) < 1e-6F;
}

// Two triangles side by side, one above the other. Vertex 3 passes through triangle 0 at half of the step and stops as
// far below as it was above; the other two vertices of its triangle stay behind.
constexpr const char* kAbove = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1 1.5 8\nv 1.5 1 8\nf 1 2 3\nf 4 5 6\n";
constexpr const char* kBelow = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1 1.5 8\nv 1.5 1 8\nf 1 2 3\nf 4 5 6\n";

// Two slim triangles whose long edges cross in the middle of the step.
constexpr const char* kEdgesApart = "v -2 0 0\nv 2 0 0\nv 0 0 -9\nv 0 -2 1\nv 0 2 1\nv 0 0 9\nf 1 2 3\nf 4 5 6\n";
constexpr const char* kEdgesCrossed = "v -2 0 0\nv 2 0 0\nv 0 0 -9\nv 0 -2 -1\nv 0 2 -1\nv 0 0 9\nf 1 2 3\nf 4 5 6\n";

class Detect : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_DETECT, arguments, folder_); }

  // Returns the contacts that `arguments` find.
  std::vector<Row> contacts(const std::string& arguments) const {
    const Result result = run(arguments + " --contacts " + folder_.file("contacts.csv"));
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, IsEmpty());
    std::istringstream rows(folder_.read("contacts.csv"));
    std::string row;
    std::getline(rows, row);
    EXPECT_EQ(row, "kind,a0,a1,b0,b1,b2,toi,distance");
    std::vector<Row> contacts;
    while (std::getline(rows, row)) contacts.push_back(parse_row(row));
    return contacts;
  }

  nlohmann::json figures(const std::string& arguments) const {
    const Result result = run(arguments + " --json " + folder_.file("figures.json"));
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return nlohmann::json::parse(folder_.read("figures.json"));
  }

  void expect_refused(const std::string& arguments, const std::string& problem) const {
    test::expect_refused(SOFTCD_DETECT, arguments, folder_, problem);
  }

  TemporaryFolder folder_;
};

TEST_F(Detect, help_names_every_option) {
  const Result result = run("--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* option : {"--backend", "--detection", "--vertex-triangle", "--accuracy", "--margin",
                             "--cell-size-factor", "--subdivision", "--broad-phase", "--memory-limit", "--contacts",
                             "--json", "--repeat", "--intersections", "--coloured"}) {
    EXPECT_THAT(result.output, HasSubstr(option));
  }
  EXPECT_THAT(result.output, testing::Not(HasSubstr("automatic"))) << "the word of the flags is auto";
}

/// Returns a word for another value than the default.
template <class Value>
std::string other_word(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return kEnumerators<Value>[value == Value{1} ? 0 : 1];
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value ? "off" : "on";
  } else {
    return std::is_same_v<Value, std::uint64_t> ? "30000000" : "2";
  }
}

TEST_F(Detect, every_option_of_the_library_has_a_flag_but_for_those_that_one_body_has_no_use_for) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  std::vector<std::string> without_flag;
  const auto expect_flags = [&]<class Options>(Options options) {
    for_each_field<Options>([&](auto field) {
      std::string flag = field.kName;
      std::replace(flag.begin(), flag.end(), '_', '-');
      using Value = typename decltype(field)::Value;
      if constexpr (std::is_enum_v<Value> || std::is_arithmetic_v<Value>) {
        const std::string word = other_word(field.of(options));
        const char* const where = flag == "backend" ? "" : " --backend cpu";
        const Result result =
            run(fmt::format("{} --{} {} --json {}{}", frames, flag, word, folder_.file("figures.json"), where));
        if (result.exit_code == 2) return without_flag.emplace_back(field.kName), void();
        const auto value = nlohmann::json::parse(folder_.read("figures.json"))[field.kName];
        std::string text = value.is_string() ? value.template get<std::string>() : value.dump();
        if constexpr (std::is_same_v<Value, bool>) text = value.template get<bool>() ? "on" : "off";
        EXPECT_EQ(text.substr(0, text.find('.')), word) << field.kName;
      }
    });
  };
  QueryOptions defaults;
  defaults.detection = Detection::ccd;
  expect_flags(SceneOptions());
  expect_flags(defaults);
  EXPECT_THAT(without_flag, ElementsAre("motion_margin", "step_end", "margins", "neighbour_filters", "reuse_pairs",
                                        "contacts_on_device"));
}

TEST_F(Detect, finds_a_vertex_that_passes_through_a_triangle) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  EXPECT_THAT(contacts(frames + " --edge-edge off"), ElementsAre(is_contact("vt,3,,0,1,2", 0.5F, 0.0F)));
  EXPECT_THAT(contacts(frames + " --detection dcd --edge-edge off"), IsEmpty());
  EXPECT_THAT(contacts(frames + " --detection dcd --edge-edge off --margin 0.5"),
              ElementsAre(is_contact("vt,3,,0,1,2", 1.0F, 1.0F)));
  EXPECT_THAT(contacts(frames + " --detection dcd --edge-edge off --margin 0.499"), IsEmpty());
}

TEST_F(Detect, finds_edges_that_cross) {
  const std::string frames = folder_.write("t0.obj", kEdgesApart) + " " + folder_.write("t1.obj", kEdgesCrossed);
  EXPECT_THAT(contacts(frames + " --vertex-triangle off"), ElementsAre(is_contact("ee,0,1,3,4,", 0.5F, 0.0F)));
}

TEST_F(Detect, every_broad_phase_finds_the_same_here) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  const std::vector<Row> expected = contacts(frames);
  EXPECT_THAT(expected, testing::Contains(is_contact("vt,3,,0,1,2", 0.5F, 0.0F)));
  EXPECT_EQ(contacts(frames + " --broad-phase uniform"), expected);
  EXPECT_EQ(contacts(frames + " --subdivision off"), expected);
  EXPECT_EQ(contacts(frames + " --cell-size-factor 2.4"), expected);
  EXPECT_EQ(contacts(frames + " --backend cpu --vertex-triangle on --edge-edge on"), expected);
  EXPECT_EQ(contacts(frames + " --repeat 3"), expected);
}

TEST_F(Detect, one_frame_is_enough_for_discrete_detection) {
  const std::string frame = folder_.write("t1.obj", kBelow);
  EXPECT_THAT(contacts("--detection dcd --edge-edge off --margin 0.5 " + frame),
              ElementsAre(is_contact("vt,3,,0,1,2", 1.0F, 1.0F)));
  expect_refused(frame, "needs two frames");
}

/// The second triangle stands in the first one with a corner below it.
TEST_F(Detect, finds_and_colours_regions_of_intersections) {
  const std::string mesh = folder_.write("through.obj", kBelow);
  const std::string coloured = folder_.file("out.ply");
  const Result result =
      run(mesh + " --intersections regions --coloured " + coloured + " --json " + folder_.file("out.json"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("2 regions on the wrong side, 1 curves"));
  const auto json = nlohmann::json::parse(folder_.read("out.json"));
  EXPECT_EQ(json["curves"], 1);
  EXPECT_EQ(json["regions"].size(), 2U);
  const std::string ply = folder_.read("out.ply");
  EXPECT_THAT(ply, HasSubstr("property uchar red"));
  EXPECT_EQ(run(coloured + " --intersections regions").output, result.output) << "the mesh can be read again";
  expect_refused(mesh + " --detection dcd --coloured out.ply", "needs --intersections regions");
  expect_refused(mesh + " --intersections regions --contacts out.csv", "leave out --contacts");
  expect_refused(mesh + " --intersections regions --coloured out.stl", "only PLY files have colours");
}

TEST_F(Detect, json_holds_every_figure) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  const nlohmann::json json = figures(frames + " --edge-edge off --backend cpu --repeat 2");
  EXPECT_EQ(json["triangles"], 2);
  EXPECT_EQ(json["vertices"], 6);
  EXPECT_EQ(json["edges"], 6);
  EXPECT_EQ(json["backend"], "cpu");
  EXPECT_EQ(json["detection"], "ccd");
  EXPECT_EQ(json["broad_phase"], "exact");
  EXPECT_EQ(json["accuracy"], "auto");
  EXPECT_EQ(json["vt_contacts"], 1);
  EXPECT_EQ(json["ee_contacts"], 0);
  EXPECT_LE(json["earliest_toi"], 0.5) << "never late";
  EXPECT_NEAR(json["earliest_toi"], 0.5, 1e-7);
  EXPECT_EQ(json["repeat"], 2);
  for (const char* key : {"cell_size_factor", "cell_size", "children", "entries", "cells", "tests", "triangle_pairs",
                          "vt_candidates", "ee_candidates", "peak_bytes"}) {
    EXPECT_TRUE(json[key].is_number()) << key;
  }
  for (const char* stage :
       {"total", "volumes", "subdivision", "assignment", "sort", "tests", "features", "narrow", "transfer"}) {
    EXPECT_TRUE(json["ms"][stage].is_number()) << stage;
  }
  EXPECT_GT(json["ms"]["total"], 0);
}

TEST_F(Detect, empty_and_single_triangle_meshes_have_no_contacts) {
  const std::string empty = folder_.write("empty.obj", "");
  EXPECT_THAT(contacts(empty + " " + empty), IsEmpty());
  const std::string one = folder_.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(contacts(one + " " + one), IsEmpty());
  EXPECT_EQ(figures(one + " " + one)["triangles"], 1);
}

TEST_F(Detect, leaves_triangles_out_whose_vertices_are_not_finite) {
  const std::string above = "v 9 9 9\nv 9 9 10\nv 9 10 9\nf -1 -2 -3\n";
  const std::string broken = "v nan 9 9\nv 9 9 10\nv 9 10 9\nf -1 -2 -3\n";
  const std::string frames = folder_.write("t0.obj", kAbove + above) + " " + folder_.write("t1.obj", kBelow + broken);
  const Result result = run(frames + " --edge-edge off --repeat 3 --json " + folder_.file("figures.json") +
                            " --contacts " + folder_.file("contacts.csv"));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.errors, HasSubstr("warning"));
  EXPECT_EQ(result.errors.find("warning"), result.errors.rfind("warning")) << "the repetitions repeat it";
  EXPECT_THAT(folder_.read("contacts.csv"), HasSubstr("\nvt,3,,0,1,2,"));
  EXPECT_EQ(nlohmann::json::parse(folder_.read("figures.json"))["left_out_triangles"], 1);
}

TEST_F(Detect, refuses_meshes_with_one_sentence) {
  const std::string good = folder_.write("good.obj", kAbove);
  const auto expect_sentence = [&](const std::string& file, const std::string& place, const std::string& problem) {
    const Result result = run(good + " " + file);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.errors, HasSubstr(file + place));
    EXPECT_THAT(result.errors, HasSubstr(problem));
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    EXPECT_THAT(result.output, IsEmpty());
  };
  expect_sentence(folder_.file("absent.ply"), ":", "cannot be opened");
  expect_sentence(folder_.write("garbage.ply", "\x89PNG\r\n"), ":", "is neither PLY");
  expect_sentence(folder_.write("cut.ply", "ply\nformat ascii 1.0\nelement"), ":3:", "is not a number of elements");
  expect_sentence(folder_.write("range.obj", "v 0 0 0\nf 1 1 2\n"), ":2:", "vertex index 2 does not exist");
  expect_sentence(folder_.write("negative.obj", "v 0 0 0\nf 1 1 -2\n"), ":2:", "vertex index -2 does not exist");
  expect_sentence(folder_.write("fewer.obj", "v 0 0 0\nf 1 1 1\n"), ":", "it has 1 vertices, not 6");
  expect_sentence(folder_.write("other.obj", std::string(kAbove) + "f 1 1 1\n"), ":", "it has 3 triangles, not 2");
}

TEST_F(Detect, refuses_command_lines) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  expect_refused("", "t0 is required");
  expect_refused(frames + " --accuracy exact", "'exact' is not one of fast, precise, conservative, auto");
  expect_refused(frames + " --backend gpu", "'gpu' is not one of auto, cpu, cuda");
  expect_refused(frames + " --edge-edge maybe", "'maybe' is not one of on, off");
  expect_refused(frames + " --subdivision maybe", "'maybe' is not one of on, off");
  expect_refused(frames + " --margin -1", "margin");
  expect_refused(frames + " --margin nan", "margin");
  expect_refused(frames + " --cell-size-factor -1", "cell_size_factor");
  expect_refused(frames + " --repeat 0", "--repeat");
  expect_refused(frames + " --speed 9", "--speed");
  expect_refused(frames + " --memory-limit lots", "--memory-limit");
  expect_refused(frames + " --memory-limit -1", "--memory-limit");
}

TEST_F(Detect, refuses_empty_file_names) {
  const std::string frame = folder_.write("t1.obj", kBelow);
  expect_refused(frame + " " + frame + " --contacts ''", "--contacts: is empty");
  expect_refused(frame + " " + frame + " --json ''", "--json: is empty");
  expect_refused("'' " + frame, "t0: is empty");
  expect_refused("--detection dcd " + frame + " ''", "t1: is empty");
}

TEST_F(Detect, refuses_devices_and_names_files_that_cannot_be_read) {
  const std::string good = folder_.write("good.obj", kAbove);
  expect_refused("/dev/zero " + good, "/dev/zero: is neither a file nor a pipe");
  expect_refused("/proc/self/mem " + good, "/proc/self/mem: cannot be read");
}

TEST_F(Detect, reads_frames_from_pipes) {
  const std::string frame = folder_.write("t1.obj", kBelow);
  const std::string pipe = folder_.file("pipe.obj");
  const Result result = run_shell(
      "mkfifo " + pipe + "; cat " + frame + " >" + pipe + " & '" SOFTCD_DETECT "' --detection dcd " + pipe, folder_);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("2 triangles"));
}

TEST_F(Detect, memory_limit_has_units) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  EXPECT_EQ(figures(frames)["memory_limit"], 0);
  EXPECT_EQ(figures(frames + " --memory-limit 30000000")["memory_limit"], 30000000);
  EXPECT_EQ(figures(frames + " --memory-limit 30M")["memory_limit"], 30000000);
  EXPECT_EQ(figures(frames + " --memory-limit 1GiB")["memory_limit"], 1 << 30);
  EXPECT_EQ(contacts(frames + " --memory-limit 30M"), contacts(frames));
}

TEST_F(Detect, fails_where_the_memory_limit_does_not_suffice) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  const Result result = run(frames + " --memory-limit 1k");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("memory"));
  EXPECT_THAT(result.output, IsEmpty());
}

TEST_F(Detect, results_that_cannot_be_written_are_an_error) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  for (const char* option : {" --contacts ", " --json "}) {
    const Result result = run(frames + option + folder_.file("absent/file"));
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.errors, HasSubstr("cannot be written"));
  }
}

TEST_F(Detect, a_summary_that_cannot_be_written_is_an_error) {
  const std::string frames = folder_.write("t0.obj", kAbove) + " " + folder_.write("t1.obj", kBelow);
  for (const std::string& arguments : {frames, std::string("--help")}) {
    for (const char* output : {" >/dev/full", " >&-"}) {
      const Result result = run_shell("('" SOFTCD_DETECT "' " + arguments + output + ")", folder_);
      EXPECT_EQ(result.exit_code, 1) << arguments << output;
      EXPECT_THAT(result.errors, HasSubstr("softcd-detect: standard output cannot be written"));
    }
  }
}

TEST_F(Detect, names_that_are_not_utf8_are_replaced_in_json) {
  const std::string name = "t1-\xFF.obj";
  const nlohmann::json json = figures("--detection dcd '" + folder_.write(name, kBelow) + "'");
  EXPECT_THAT(json["t0"].get<std::string>(), testing::EndsWith("/t1-\xEF\xBF\xBD.obj"));
  EXPECT_EQ(json["triangles"], 2);
}

// A mesh's edges in the order that Contact documents.
std::vector<std::array<std::uint32_t, 2>> edges_of(const std::vector<Triangle>& triangles) {
  std::set<std::array<std::uint32_t, 2>> edges;
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) edges.insert({std::min(t.v[i], t.v[(i + 1) % 3]), std::max(t.v[i], t.v[(i + 1) % 3])});
  }
  return {edges.begin(), edges.end()};
}

// A pair's columns in the contacts' file.
std::string columns_of(const FeaturePair& pair, const std::vector<Triangle>& triangles,
                       const std::vector<std::array<std::uint32_t, 2>>& edges) {
  if (pair.kind == ContactKind::vertex_triangle) {
    const auto& f = triangles[pair.feature_b].v;
    return fmt::format("vt,{},,{},{},{}", pair.feature_a, f[0], f[1], f[2]);
  }
  const auto& e = edges[pair.feature_a];
  const auto& g = edges[pair.feature_b];
  return fmt::format("ee,{},{},{},{},", e[0], e[1], g[0], g[1]);
}

// Returns the pairs that are not among the contacts of the frames.
std::vector<std::string> missed(const std::vector<Row>& contacts, const std::vector<FeaturePair>& pairs,
                                const std::vector<Triangle>& triangles) {
  std::set<std::string> found;
  for (const Row& row : contacts) found.insert(row.features);
  const auto edges = edges_of(triangles);
  std::vector<std::string> missed;
  for (const FeaturePair& pair : pairs) {
    const std::string columns = columns_of(pair, triangles, edges);
    if (found.count(columns) == 0) missed.push_back(columns);
  }
  return missed;
}

TEST_F(Detect, finds_every_true_collision_of_a_step_of_the_demo) {
  const std::string folder = recorded_step_folder("folding-cloth").string();
  const Scene scene = recorded_step("folding-cloth");
  const std::vector<FeaturePair> expected = continuous_verdicts(scene).certain;
  EXPECT_GT(expected.size(), 50u);
  EXPECT_THAT(missed(contacts("'" + folder + "/t0.ply' '" + folder + "/t1.ply'"), expected, scene[0].triangles),
              IsEmpty());
}

TEST_F(Detect, finds_every_true_collision_of_the_cloth_ball_step) {
  const std::filesystem::path data = data_folder("ccd-steps");
  if (data.empty()) GTEST_SKIP() << missing_data("ccd-steps");
  const std::string frames = (data / "cloth-ball/frames/cloth_ball").string();
  const GroundTruth truth = read_ground_truth(data, "cloth-ball");
  EXPECT_GT(truth.colliding().size(), 100000u);
  EXPECT_THAT(
      missed(contacts("'" + frames + "92.ply' '" + frames + "93.ply'"), truth.colliding(), truth.scene[0].triangles),
      IsEmpty());
}

}  // namespace
}  // namespace softcd::test
