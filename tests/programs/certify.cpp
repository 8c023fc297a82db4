#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "ground_truth.hpp"
#include "mesh_tools/mesh_io.hpp"
#include "queries.hpp"
#include "recorded_steps.hpp"
#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Two triangles side by side, one above the other, whose vertex 3 is at (1, 1, z).
std::string standing_at(const std::string& z) {
  return "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 " + z + "\nv 1 1.5 8\nv 1.5 1 8\nf 1 2 3\nf 4 5 6\n";
}

// Two slim triangles, whose long edges are `height` apart at right angles.
std::string edges_at(const std::string& height) {
  return "v -2 0 0\nv 2 0 0\nv 0 0 -9\nv 0 -2 " + height + "\nv 0 2 " + height + "\nv 0 0 9\nf 1 2 3\nf 4 5 6\n";
}

constexpr std::uint32_t kSide = 20;

// A square sheet of kSide x kSide vertices at the height z, displaced by `shift`. Vertex `dent` is at `dent_z`.
std::string sheet(double z, double shift, std::uint32_t dent, double dent_z) {
  std::string text;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const std::uint32_t row = i / kSide;
    text += fmt::format("v {} {} {}\n", 0.1 * (i % kSide) + shift, 0.1 * row + shift, i == dent ? dent_z : z);
  }
  return text;
}

std::string triangles_of_sheet(std::uint32_t first_vertex) {
  std::string text;
  for (std::uint32_t row = 0; row + 1 < kSide; ++row) {
    for (std::uint32_t column = 0; column + 1 < kSide; ++column) {
      const std::uint32_t v = first_vertex + row * kSide + column + 1;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", v, v + 1, v + kSide, v + 1, v + kSide + 1, v + kSide);
    }
  }
  return text;
}

constexpr std::uint32_t kDent = kSide * (kSide / 2) + kSide / 2;

// A flat sheet, and another one above it with a dent.
std::string two_sheets(double z, double dent_z) {
  return sheet(0, 0, kNoIndex, 0) + sheet(z, 0.03, kDent, dent_z) + triangles_of_sheet(0) +
         triangles_of_sheet(kSide * kSide);
}

class Certify : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_CERTIFY, arguments, folder_); }

  /// Returns the certificate of `arguments`, which end with that exit code.
  nlohmann::json certificate(const std::string& arguments, int exit_code) const {
    const Result result = run(arguments + " --json " + folder_.file("certificate.json"));
    EXPECT_EQ(result.exit_code, exit_code) << result.errors;
    nlohmann::json json = nlohmann::json::parse(folder_.read("certificate.json"));
    EXPECT_EQ(json["verdict"], exit_code == 0 ? "proved" : "not proved");
    EXPECT_THAT(result.output, HasSubstr(exit_code == 0 ? "proved: " : "not proved: "));
    EXPECT_EQ(result.errors.empty(), exit_code == 0) << result.errors;
    return json;
  }

  /// Writes frames as folder/frame0.obj and so on, and returns the folder.
  std::string write_frames(const std::string& folder, const std::vector<std::string>& frames) const {
    std::filesystem::create_directory(folder_.file(folder));
    for (std::size_t i = 0; i < frames.size(); ++i) folder_.write(fmt::format("{}/frame{}.obj", folder, i), frames[i]);
    return folder_.file(folder);
  }

  void expect_refused(const std::string& arguments, const std::string& problem) const {
    test::expect_refused(SOFTCD_CERTIFY, arguments, folder_, problem);
  }

  TemporaryFolder folder_;
};

TEST_F(Certify, help_names_every_option_and_exit_code) {
  const Result result = run("--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* word : {"--against", "--margin", "--every", "--list", "--backend", "--json", "--check", "0 proved",
                           "1 not proved", "2 the command line"}) {
    EXPECT_THAT(result.output, HasSubstr(word));
  }
}

TEST_F(Certify, proves_that_nothing_crosses) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("0.5"), standing_at("1e-9")});
  const nlohmann::json json = certificate(frames, 0);
  EXPECT_EQ(json["format"], "softcd-certificate 1");
  EXPECT_EQ(json["claim"],
            "While all vertices move straight and evenly from each frame to the next, no vertex touches a triangle and "
            "no edge an edge, unless they share a vertex; in no frame do triangles intersect");
  EXPECT_EQ(json["arithmetic"]["steps"], "conservative");
  EXPECT_EQ(json["meshes"][0]["vertices"], 6);
  EXPECT_EQ(json["meshes"][0]["triangles"], 2);
  EXPECT_EQ(json["meshes"][0]["files"][2]["name"], "frame2.obj");
  EXPECT_EQ(json["proved_steps"], 2);
  EXPECT_EQ(json["steps"][1], nlohmann::json({{"from", 1}, {"to", 2}, {"verdict", "proved"}}));
  EXPECT_EQ(json["frames"][2], nlohmann::json({{"frame", 2}, {"intersections", 0}}));
}

#ifdef SOFTCD_DEMO
TEST_F(Certify, reads_the_same_from_gltf_as_from_ply) {
  const auto certificate_of = [this](const std::string& format) {
    std::filesystem::create_directory(folder_.file(format));
    const std::string files = "'" + folder_.file(format) + "/frame-####." + format + "'";
    const Result result = run_shell("cd '" + folder_.file("") +
                                        "' && '" SOFTCD_DEMO
                                        "' two-cloths --size 12 --steps 40 --frame-steps 2 --collision off "
                                        "--picture-size 64x40 --export " +
                                        files,
                                    folder_);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return certificate(folder_.file(format), 1);
  };
  const nlohmann::json ply = certificate_of("ply");
  const nlohmann::json glb = certificate_of("glb");
  EXPECT_EQ(glb["meshes"][0]["files"][1]["name"], "frame-0001.glb");
  EXPECT_EQ(glb["meshes"][0]["vertices"], ply["meshes"][0]["vertices"]);
  EXPECT_LT(ply["proved_steps"], ply["steps"].size());
  EXPECT_EQ(glb["steps"], ply["steps"]);
  EXPECT_EQ(glb["frames"], ply["frames"]);
}
#endif

TEST_F(Certify, hashes_are_those_of_the_files) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("2")});
  const nlohmann::json json = certificate(frames, 0);
  const Result sums = run_shell("sha256sum " + frames + "/frame1.obj", folder_);
  EXPECT_EQ(json["meshes"][0]["files"][1]["sha256"], sums.output.substr(0, 64));
}

TEST_F(Certify, finds_edges_that_cross_by_a_millionth) {
  const nlohmann::json json = certificate(write_frames("crossing", {edges_at("1"), edges_at("-1e-6")}), 1);
  const nlohmann::json step = json["steps"][0];
  EXPECT_EQ(step["verdict"], "crossed");
  EXPECT_EQ(step["pairs"]["count"], 1);
  const nlohmann::json pair = step["pairs"]["listed"][0];
  EXPECT_EQ(pair["kind"], "ee");
  EXPECT_EQ(pair["a"]["vertices"], nlohmann::json({0, 1}));
  EXPECT_EQ(pair["b"]["vertices"], nlohmann::json({3, 4}));
  EXPECT_EQ(pair["crossed"], true);
  EXPECT_NEAR(pair["time"], 1 / 1.000001, 1e-6);
  certificate(write_frames("apart", {edges_at("1"), edges_at("1e-6")}), 0);
}

TEST_F(Certify, finds_one_vertex_of_a_sheet_that_crosses_by_a_millionth) {
  const nlohmann::json json = certificate(write_frames("crossing", {two_sheets(0.1, 0.1), two_sheets(0.05, -1e-6)}), 1);
  const nlohmann::json step = json["steps"][0];
  EXPECT_EQ(step["verdict"], "crossed");
  ASSERT_EQ(step["pairs"]["count"], 1) << step;
  EXPECT_EQ(step["pairs"]["listed"][0]["kind"], "vt");
  EXPECT_EQ(step["pairs"]["listed"][0]["a"]["vertices"], nlohmann::json({kSide * kSide + kDent}));
  EXPECT_EQ(json["frames"][0]["intersections"], 0);
  EXPECT_EQ(json["frames"][1]["intersections"], 6) << "the triangles around the vertex";
  EXPECT_EQ(step["changed_intersections"]["count"], 6);
  certificate(write_frames("apart", {two_sheets(0.1, 0.1), two_sheets(0.05, 1e-6)}), 0);
}

TEST_F(Certify, positions_in_double_are_not_rounded) {
  // One part in 10^12 above, and below, a scene as wide as 4.
  certificate(write_frames("apart", {edges_at("1"), edges_at("1e-12")}), 0);
  const nlohmann::json json = certificate(write_frames("crossing", {edges_at("1"), edges_at("-1e-12")}), 1);
  EXPECT_EQ(json["steps"][0]["verdict"], "crossed");
  EXPECT_EQ(json["frames"][1]["pairs"][0]["through"], true);
}

// The float of the tip's height is below the flat triangle, which it pierces.
TEST_F(Certify, finds_triangles_of_a_wide_scene_that_intersect_by_less_than_floats_can_say) {
  const auto scene = [](const char* tip) {
    return "v 0 0 1000.00002\nv 4 0 1000.00002\nv 0 4 1000.00002\nv 1 1 " + std::string(tip) +
           "\nv 1 1.5 900\nv 1.5 1 900\nv 0 0 -1000\nv 1 0 -1000\nv 0 1 -1000\nf 1 2 3\nf 4 5 6\nf 7 8 9\n";
  };
  const nlohmann::json json = certificate(write_frames("through", {scene("1000.000021"), scene("1000.000021")}), 1);
  EXPECT_EQ(json["frames"][0]["intersections"], 1);
  certificate(write_frames("apart", {scene("1000.000019"), scene("1000.000019")}), 0);
}

TEST_F(Certify, finds_what_passes_through_whole_within_a_step) {
  const std::string below = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -9\nv 1 1.5 -2\nv 1.5 1 -2\nf 1 2 3\nf 4 5 6\n";
  const nlohmann::json json = certificate(write_frames("frames", {standing_at("1"), below}), 1);
  EXPECT_EQ(json["intersecting_frames"], 0);
  EXPECT_EQ(json["steps"][0]["verdict"], "crossed");
  EXPECT_EQ(json["steps"][0]["pairs"]["count"], 3) << "three vertices";
  for (const nlohmann::json& pair : json["steps"][0]["pairs"]["listed"]) EXPECT_EQ(pair["crossed"], true);
}

TEST_F(Certify, touching_is_not_proved_and_not_called_a_crossing) {
  const nlohmann::json json =
      certificate(write_frames("frames", {standing_at("1"), standing_at("0"), standing_at("1")}), 1);
  for (const nlohmann::json& step : json["steps"]) EXPECT_EQ(step["verdict"], "not proved");
  EXPECT_EQ(json["steps"][0]["pairs"]["listed"][0]["crossed"], false);
  EXPECT_EQ(json["frames"][1]["intersections"], 1);
  EXPECT_EQ(json["frames"][1]["pairs"][0]["through"], false);
  EXPECT_EQ(json["crossed_steps"], 0);
}

// Many difficult queries side by side: the mesh of query i has the vertices from 4 i on. Vertices and edges are
// triangles without area.
struct QueryMesh {
  std::vector<Query> queries;
  std::string t0, t1;

  explicit QueryMesh(std::uint32_t count) {
    Random random(3);
    std::string triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
      const ContactKind kind = i % 2 == 0 ? ContactKind::vertex_triangle : ContactKind::edge_edge;
      Query query = make_query(random, kind, Family{i / 2 % kFamilies}, false);
      const auto row_of_twenty = i / 20;
      for (Vec3d& x : query.rows) x = x + Vec3d{16.0 * (i % 20), 16.0 * row_of_twenty, 0};
      for (std::size_t row = 0; row < 8; ++row) {
        (row < 4 ? t0 : t1) += fmt::format("v {} {} {}\n", query.rows[row].x, query.rows[row].y, query.rows[row].z);
      }
      const std::uint32_t v = 4 * i + 1;
      triangles += kind == ContactKind::vertex_triangle
                       ? fmt::format("f {0} {0} {0}\nf {1} {2} {3}\n", v, v + 1, v + 2, v + 3)
                       : fmt::format("f {0} {1} {1}\nf {2} {3} {3}\n", v, v + 1, v + 2, v + 3);
      queries.push_back(query);
    }
    t0 += triangles;
    t1 += triangles;
  }
};

TEST_F(Certify, reports_all_that_touches_and_calls_nothing_else_crossed) {
  const QueryMesh mesh(400);
  const nlohmann::json json = certificate(write_frames("frames", {mesh.t0, mesh.t1}) + " --list 10000", 1);
  std::set<std::uint32_t> reported;
  std::set<std::uint32_t> crossed;
  for (const nlohmann::json& pair : json["steps"][0]["pairs"]["listed"]) {
    const std::uint32_t first = pair["a"]["vertices"][0];
    const std::uint32_t query = first / 4;
    const bool is_vertex_triangle = mesh.queries[query].kind == ContactKind::vertex_triangle;
    if (pair["kind"] != (is_vertex_triangle ? "vt" : "ee")) continue;
    if (is_vertex_triangle && first % 4 != 0) continue;  // a corner of the triangle
    reported.insert(query);
    if (pair["crossed"] == true) crossed.insert(query);
  }
  std::uint32_t touching = 0;
  for (std::uint32_t i = 0; i < mesh.queries.size(); ++i) {
    if (collides(mesh.queries[i])) {
      ++touching;
      EXPECT_EQ(reported.count(i), 1U) << "missed: query " << i;
    } else {
      EXPECT_EQ(crossed.count(i), 0U) << "does not touch: query " << i;
    }
  }
  EXPECT_GT(touching, 100U);
  EXPECT_LT(touching, 300U);
  EXPECT_GT(crossed.size(), 20U);
  EXPECT_LT(crossed.size(), touching) << "some only touch";
}

TEST_F(Certify, bodies_that_stay_intersected_are_found_in_the_frames) {
  const nlohmann::json json = certificate(write_frames("frames", {standing_at("-1"), standing_at("-1")}), 1);
  EXPECT_EQ(json["proved_steps"], 1);
  EXPECT_EQ(json["intersecting_frames"], 2);
}

TEST_F(Certify, proves_distances) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("0.5")});
  const nlohmann::json json = certificate(frames + " --margin 0.2499", 0);
  EXPECT_THAT(json["claim"].get<std::string>(), HasSubstr("vertices stay more than 0.4998 away from triangles"));
  EXPECT_EQ(json["options"]["margin"], 0.2499);
  const nlohmann::json nearby = certificate(frames + " --margin 0.25", 1);
  EXPECT_EQ(nearby["steps"][0]["verdict"], "not proved");
  EXPECT_EQ(nearby["steps"][0]["pairs"]["listed"][0]["crossed"], false);
  EXPECT_EQ(nearby["intersecting_frames"], 0);
}

TEST_F(Certify, a_crossing_is_called_one_with_a_margin_too) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("-1")});
  const nlohmann::json json = certificate(frames + " --margin 0.4", 1);
  EXPECT_EQ(json["steps"][0]["verdict"], "crossed");
  EXPECT_EQ(json["steps"][0]["pairs"]["listed"][0]["crossed"], true);
  EXPECT_NEAR(json["steps"][0]["pairs"]["listed"][0]["time"], 0.1, 1e-6) << "within twice the margin";
}

TEST_F(Certify, compares_with_further_meshes_that_stand_still_or_move) {
  const auto level = [](const std::string& z) {
    return "v -1 -1 " + z + "\nv 7 -1 " + z + "\nv -1 7 " + z + "\nf 1 2 3\n";
  };
  const std::string high = level("1");
  const std::string low = level("-1");
  const std::string frames = write_frames("frames", {standing_at("2"), standing_at("1.5")});
  const std::string still = folder_.write("still.obj", high);
  certificate(frames + " --against " + still, 0);
  EXPECT_EQ(certificate("--against " + still + " --margin 0.26 " + frames, 1)["steps"][0]["verdict"], "not proved");

  const std::string moving = write_frames("moving", {low, high});
  EXPECT_EQ(certificate(frames + " --against " + moving, 1)["steps"][0]["verdict"], "crossed")
      << "it passes through the first triangle";
  const std::string rising = write_frames("rising", {high, level("3")});
  const nlohmann::json json = certificate(frames + " --against " + still + " --against " + rising, 1);
  EXPECT_EQ(json["meshes"].size(), 3U);
  const nlohmann::json pair = json["steps"][0]["pairs"]["listed"][0];
  EXPECT_EQ(pair["a"]["mesh"].get<int>() + pair["b"]["mesh"].get<int>(), 2) << "still and rising are not compared";
  for (const nlohmann::json& triangles : json["frames"][1]["pairs"]) EXPECT_EQ(triangles["b"]["mesh"], 2);
  EXPECT_EQ(json["frames"][1]["intersections"], 1);
}

TEST_F(Certify, further_meshes_may_intersect_each_other) {
  const std::string frames = write_frames("frames", {standing_at("2"), standing_at("1.5")});
  const std::string obstacle =
      folder_.write("crossed.obj", "v 0 0 -1\nv 4 0 -1\nv 0 4 -1\nv 1 1 -2\nv 1 1 -0.5\nv 2 1 -2\nf 1 2 3\nf 4 5 6\n");
  certificate(frames + " --against " + obstacle + " --against " + obstacle, 0);
}

TEST_F(Certify, every_uses_some_of_the_frames) {
  const std::string frames =
      write_frames("frames", {standing_at("1"), standing_at("-1"), standing_at("2"), standing_at("-1")});
  certificate(frames, 1);
  const nlohmann::json json = certificate(frames + " --every 2", 0);
  EXPECT_EQ(json["steps"].size(), 1U);
  EXPECT_EQ(json["meshes"][0]["files"][1]["name"], "frame2.obj");
  const std::string low = "v 0 0 -3\nv 4 0 -3\nv 0 4 -3\nf 1 2 3\n";
  const std::string high = "v 0 0 5\nv 4 0 5\nv 0 4 5\nf 1 2 3\n";
  certificate(frames + " --every 2 --against " + write_frames("moving", {low, high, low, high}), 0);
}

TEST_F(Certify, lists_as_many_pairs_as_wanted) {
  const std::string folder = recorded_step_folder("folding-cloth").string();
  const nlohmann::json step = certificate(folder, 1)["steps"][0];
  EXPECT_EQ(step["pairs"]["count"], 53);
  EXPECT_EQ(step["pairs"]["listed"].size(), 53U);
  for (const nlohmann::json& pair : step["pairs"]["listed"]) EXPECT_EQ(pair["crossed"], true);
  const nlohmann::json short_one = certificate(folder + " --list 0", 1);
  EXPECT_EQ(short_one["steps"][0]["pairs"]["count"], 53);
  EXPECT_EQ(short_one["steps"][0]["verdict"], "crossed");
  EXPECT_TRUE(short_one["steps"][0]["pairs"]["listed"].empty());
}

// Writes a mesh, and a vertex without triangles.
std::string with_vertex(const mesh_tools::Mesh& mesh, const std::string& vertex) {
  std::string text;
  for (const Vec3d& x : mesh.positions) text += fmt::format("v {} {} {}\n", x.x, x.y, x.z);
  text += "v " + vertex + "\n";
  for (const Triangle& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t.v[0] + 1, t.v[1] + 1, t.v[2] + 1);
  return text;
}

// If a coordinate is no float, the program finds intersecting triangles in another way.
TEST_F(Certify, finds_the_same_triangles_of_floats_and_of_doubles) {
  std::vector<std::string> floats;
  std::vector<std::string> doubles;
  for (const char* file : {"t0.ply", "t1.ply"}) {
    const mesh_tools::Mesh mesh = mesh_tools::read_mesh(recorded_step_folder("n-body") / file);
    floats.push_back(with_vertex(mesh, "0.5 0.5 0.5"));
    doubles.push_back(with_vertex(mesh, "0.1 0.1 0.1"));
  }
  const nlohmann::json of_floats = certificate(write_frames("floats", floats) + " --list 1000", 1);
  const nlohmann::json of_doubles = certificate(write_frames("doubles", doubles) + " --list 1000", 1);
  EXPECT_GT(of_floats["frames"][1]["intersections"], 100);
  EXPECT_EQ(of_floats["frames"], of_doubles["frames"]);
  EXPECT_EQ(of_floats["steps"], of_doubles["steps"]);
}

TEST_F(Certify, proves_recorded_steps_without_a_crossing) {
  for (const char* name : {"reef-knot", "tube"}) certificate(recorded_step_folder(name).string(), 0);
}

TEST_F(Certify, finds_as_many_pairs_of_the_cloth_ball_step_as_touch) {
  const std::filesystem::path data = data_folder("ccd-steps");
  if (data.empty()) GTEST_SKIP() << missing_data("ccd-steps");
  const nlohmann::json json = certificate((data / "cloth-ball/frames").string(), 1);
  EXPECT_EQ(json["steps"][0]["pairs"]["count"], read_ground_truth(data, "cloth-ball").colliding().size());
}

TEST_F(Certify, a_certificate_has_the_same_bytes_again_and_elsewhere) {
  const std::vector<std::string> texts = {standing_at("1"), standing_at("-1"), standing_at("-2")};
  const std::string frames = write_frames("frames", texts);
  certificate(frames, 1);
  const std::string first = folder_.read("certificate.json");
  certificate(write_frames("copy", texts) + " --backend cpu", 1);
  EXPECT_EQ(folder_.read("certificate.json"), first);
  EXPECT_THAT(first, Not(HasSubstr(folder_.file(""))));
  const Result result = run("--check " + folder_.file("certificate.json") + " " + frames);
  EXPECT_EQ(result.exit_code, 1) << "repeated, but not a proof";
  EXPECT_THAT(result.output, HasSubstr("certificate.json: repeated, byte for byte"));
}

TEST_F(Certify, check_repeats_with_the_options_of_the_certificate) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("-1"), standing_at("2")});
  const std::string obstacle = folder_.write("obstacle.obj", "v 0 0 -3\nv 4 0 -3\nv 0 4 -3\nf 1 2 3\n");
  certificate(frames + " --every 2 --margin 0.1 --list 5 --against " + obstacle, 0);
  const std::string check = "--check " + folder_.file("certificate.json") + " " + frames;
  const Result result = run(check + " --against " + obstacle);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("repeated, byte for byte"));
  expect_refused(check, "certificate.json: is about 1 meshes of --against, but 0 are given");
  expect_refused(check + " --against " + obstacle + " --margin 0.1", "--margin excludes --check");
}

TEST_F(Certify, check_notices_a_changed_file) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("2")});
  certificate(frames, 0);
  folder_.write("frames/frame1.obj", standing_at("2.0"));  // the same mesh in other bytes
  const Result result = run("--check " + folder_.file("certificate.json") + " " + frames);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("certificate.json: is not reproduced: frame1.obj has other content"));
}

TEST_F(Certify, check_notices_a_changed_certificate) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("-1")});
  certificate(frames, 1);
  std::string text = folder_.read("certificate.json");
  const std::size_t place = text.find("\"crossed\"");
  const Result result =
      run("--check " + folder_.write("forged.json", text.replace(place, 9, "\"proved\"")) + " " + frames);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("forged.json: is not reproduced: /steps/0/verdict was \"proved\" and is now"));
  const Result spaced =
      run("--check " + folder_.write("spaced.json", folder_.read("certificate.json") + " ") + " " + frames);
  EXPECT_EQ(spaced.exit_code, 1);
  EXPECT_THAT(spaced.errors, HasSubstr("the layout of the text is different"));
}

TEST_F(Certify, check_refuses_what_is_no_certificate) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("2")});
  for (const char* text : {"", "{}", "[1]", "{\"format\": 1}", "null"}) {
    expect_refused("--check " + folder_.write("other.json", text) + " " + frames, "other.json: is not a");
  }
  expect_refused("--check " + folder_.file("absent.json") + " " + frames, "absent.json: cannot be opened");
  certificate(frames, 0);
  expect_refused("--check " + folder_.file("certificate.json") + " " + frames + " " + frames + "/frame1.obj",
                 "is about 2 frames, but 3 are given");
}

TEST_F(Certify, a_folder_is_sorted_by_number_and_other_files_in_it_do_not_count) {
  std::vector<std::string> texts;
  for (int i = 0; i < 11; ++i) texts.push_back(standing_at(std::to_string(20 - i)));
  const std::string frames = write_frames("frames", texts);
  folder_.write("frames/notes.txt", "no mesh");
  const nlohmann::json json = certificate(frames, 0);
  EXPECT_EQ(json["meshes"][0]["files"][10]["name"], "frame10.obj");
  const Result sorted_by_shell = run(frames + "/*.obj");
  EXPECT_THAT(sorted_by_shell.errors, HasSubstr("frame10.obj comes before"));
}

TEST_F(Certify, frames_may_come_from_pipes) {
  const std::string frame = folder_.write("frame.obj", standing_at("1"));
  const std::string first = folder_.file("pipe2.obj");
  const std::string second = folder_.file("pipe1.obj");
  const Result result = run_shell("mkfifo " + first + " " + second + "; cat " + frame + " >" + first + " & cat " +
                                      frame + " >" + second + " & '" SOFTCD_CERTIFY "' " + first + " " + second,
                                  folder_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.errors, IsEmpty()) << "the order of pipes is meant";
}

TEST_F(Certify, names_both_files_where_the_topology_differs) {
  const std::string first = folder_.write("first.obj", standing_at("1"));
  const std::string other = folder_.write("other.obj", standing_at("1") + "f 1 2 4\n");
  const std::string turned =
      folder_.write("turned.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1 1.5 8\nv 1.5 1 8\nf 1 2 3\nf 4 6 5\n");
  expect_refused(first + " " + other,
                 other + ": is not a frame of the same mesh as " + first + ": it has 3 triangles, not 2");
  expect_refused(first + " " + first + " " + turned, turned + ": is not a frame of the same mesh as " + first);
}

TEST_F(Certify, errors_name_the_file_and_what_to_do) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("2")});
  const std::string frame = frames + "/frame0.obj";
  expect_refused(frame, "frame0.obj: is the only frame; give at least two");
  expect_refused(frames + " --every 2", "frame0.obj: is the only frame; give at least two, or a smaller --every");
  expect_refused(frame + " " + folder_.file("absent.ply"), "absent.ply: does not exist");
  expect_refused(frame + " " + folder_.write("nan.obj", standing_at("nan")), "nan.obj: vertex 3 is not finite");
  expect_refused(frame + " " + folder_.write("far.obj", standing_at("1e38")),
                 "far.obj: vertex 3 is not finite or beyond 1e37");
  expect_refused(folder_.write("empty.obj", "") + " " + frame, "empty.obj: has no triangles");
  std::filesystem::create_directory(folder_.file("none"));
  expect_refused(folder_.file("none"), "none: has no files with names ending in .ply, .obj or .glb");
  expect_refused(frames + " --against " + write_frames("three", {frame, frame, frame}),
                 "three: has 3 meshes, but there are 2 frames");
  expect_refused(frames + " --against " + folder_.file("absent.obj"), "absent.obj: does not exist");
}

TEST_F(Certify, refuses_command_lines) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("2")});
  expect_refused("", "frames is required");
  expect_refused(frames + " --margin -1", "--margin: must be from 0 to 1e37");
  expect_refused(frames + " --margin nan", "--margin");
  expect_refused(frames + " --every 0", "--every");
  expect_refused(frames + " --backend gpu", "'gpu' is not one of auto, cpu, cuda");
  expect_refused(frames + " --json ''", "--json: is empty");
  expect_refused(frames + " ''", "frames: is empty");
  expect_refused(frames + " --speed 9", "--speed");
}

TEST_F(Certify, a_certificate_that_cannot_be_written_is_an_error) {
  const std::string frames = write_frames("frames", {standing_at("1"), standing_at("2")});
  const Result result = run(frames + " --json " + folder_.file("absent/certificate.json"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("certificate.json: cannot be written"));
}

}  // namespace
}  // namespace softcd::test
