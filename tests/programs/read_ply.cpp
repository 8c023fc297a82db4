#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>
#include <limits>

#include "mesh_reading.hpp"

namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Ply : public MeshReading {
 protected:
  static constexpr const char* kTriangleHeader =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

  static std::string header(const std::string& format, const std::string& scalar, const std::string& index,
                            std::size_t vertex_count, std::size_t face_count) {
    return fmt::format(
        "ply\nformat {} 1.0\ncomment written by a test\nelement vertex {}\nproperty {} x\nproperty {} y\n"
        "property uchar red\nproperty {} z\nelement face {}\nproperty list uchar {} vertex_indices\n"
        "property short patch\nend_header\n",
        format, vertex_count, scalar, scalar, scalar, face_count, index);
  }

  // Returns a number's bytes in the file's order.
  template <class T>
  static std::string bytes(T value, bool big_endian) {
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big_endian != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    return {raw.begin(), raw.end()};
  }

  // Returns two triangles and a quadrilateral over `positions`, with properties that a reader must skip.
  template <class Scalar, class Index>
  static std::string binary(const std::string& format, const std::string& scalar, const std::string& index,
                            const std::vector<Vec3<Scalar>>& positions) {
    const bool big = format == "binary_big_endian";
    std::string content = header(format, scalar, index, positions.size(), 2);
    for (const auto& p : positions) {
      content += bytes(p.x, big) + bytes(p.y, big) + "\x7f" + bytes(p.z, big);
    }
    const auto face = [&](const std::vector<Index>& corners) {
      content += bytes(static_cast<std::uint8_t>(corners.size()), big);
      for (const Index corner : corners) content += bytes(corner, big);
      content += bytes(std::int16_t{-2}, big);
    };
    face({0, 1, 2});
    face({3, 2, 1, 0});
    return content;
  }

  template <class Scalar, class Index>
  void expect_round_trip(const std::string& format, const std::string& scalar, const std::string& index) {
    const Scalar third = Scalar(1) / 3;
    const std::vector<Vec3<Scalar>> positions = {{third, -third, 0},
                                                 {std::numeric_limits<Scalar>::max(), 1, Scalar(1e-30)},
                                                 {std::numeric_limits<Scalar>::denorm_min(), Scalar(-0.0), 10},
                                                 {std::numeric_limits<Scalar>::quiet_NaN(), 2, 3}};
    const mesh_tools::Mesh mesh = read("mesh.ply", binary<Scalar, Index>(format, scalar, index, positions));
    ASSERT_EQ(mesh.positions.size(), positions.size());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(mesh.positions[i].x, double(positions[i].x));
      EXPECT_EQ(mesh.positions[i].y, double(positions[i].y));
      EXPECT_EQ(mesh.positions[i].z, double(positions[i].z));
    }
    EXPECT_TRUE(std::isnan(mesh.positions[3].x));
    using T = std::array<std::uint32_t, 3>;
    EXPECT_THAT(triangles_of(mesh), ElementsAre(T{0, 1, 2}, T{3, 2, 1}, T{3, 1, 0}));
  }
};

TEST_F(Ply, reads_binary_of_both_endiannesses_and_many_types) {
  for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
    SCOPED_TRACE(format);
    expect_round_trip<float, std::int32_t>(format, "float", "int");
    expect_round_trip<double, std::uint32_t>(format, "double", "uint");
    expect_round_trip<float, std::uint16_t>(format, "float32", "uint16");
    expect_round_trip<double, std::int8_t>(format, "float64", "int8");
  }
}

TEST_F(Ply, reads_integer_positions) {
  const mesh_tools::Mesh mesh =
      read("mesh.ply", binary<std::int16_t, std::uint8_t>("binary_big_endian", "short", "uchar",
                                                          {{-300, 2, 3}, {0, 0, 0}, {1, 1, 1}, {}}));
  EXPECT_EQ(mesh.positions[0], (Vec3d{-300, 2, 3}));
}

TEST_F(Ply, reads_ascii_as_the_types_that_the_header_names) {
  const mesh_tools::Mesh mesh = read("mesh.ply",
                                     "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\n"
                                     "property double y\r\nproperty int z\r\nelement face 1\r\n"
                                     "property list uchar uint vertex_index\r\nend_header\r\n"
                                     "0.1 0.1 -7\r\n  +1e3\t-2.5 0 nan inf 1\r\n0 0 0\r\n4 0 1 2 3\r\n\r\n");
  EXPECT_EQ(mesh.positions[0], (Vec3d{double(0.1F), 0.1, -7}));
  EXPECT_EQ(mesh.positions[1], (Vec3d{1000, -2.5, 0}));
  EXPECT_TRUE(std::isnan(mesh.positions[2].x));
  EXPECT_TRUE(std::isinf(mesh.positions[2].y));
  using T = std::array<std::uint32_t, 3>;
  EXPECT_THAT(triangles_of(mesh), ElementsAre(T{0, 1, 2}, T{0, 2, 3}));
}

TEST_F(Ply, steps_over_other_elements_and_reads_faces_before_vertices) {
  const mesh_tools::Mesh mesh =
      read("mesh.ply",
           "ply\nformat ascii 1.0\nobj_info x\nelement strange 2\nproperty list int double values\n"
           "element face 1\nproperty list int int vertex_indices\n"
           "element vertex 3\nproperty float z\nproperty float y\nproperty float x\n"
           "property list uchar float weights\nend_header\n"
           "2 0.5 0.5\n0\n3 2 1 0\n1 2 3 0\n4 5 6 2 9 9\n7 8 9 0\n");
  EXPECT_EQ(mesh.positions[1], (Vec3d{6, 5, 4}));
  using T = std::array<std::uint32_t, 3>;
  EXPECT_THAT(triangles_of(mesh), ElementsAre(T{2, 1, 0}));
}

TEST_F(Ply, reads_meshes_without_faces_or_vertices) {
  const mesh_tools::Mesh empty = read("mesh.ply",
                                      "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\n"
                                      "property float y\nproperty float z\nend_header\n");
  EXPECT_TRUE(empty.positions.empty());
  EXPECT_TRUE(empty.triangles.empty());
}

TEST_F(Ply, names_what_is_wrong_with_a_header) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string vertices = "element vertex 0\n" + xyz;
  const std::string ascii = "ply\nformat ascii 1.0\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"ply\n", ":1: the header has no end_header"},
      {"ply\nformat ascii 1.0\nelement vertex", "'' is not a number"},
      {"ply\nformat ascii 1.0\n" + vertices, "no end_header"},
      {"ply\n" + vertices + "end_header\n", "names no format"},
      {"ply\nformat ascii 2.0\n", ":2: unknown PLY version '2.0'"},
      {"ply\nformat ebcdic 1.0\n", "unknown format 'ebcdic'"},
      {ascii + "property float x\n", ":3: a property comes before the first element"},
      {ascii + "element vertex -1\n", "'-1' is not a number of elements"},
      {ascii + "element vertex 99999999999999999999\n", "is not a number of elements"},
      {ascii + "element vertex 4294967296\n" + xyz + "end_header\n", "too many"},
      {ascii + vertices + vertices, "element 'vertex' is declared twice"},
      {ascii + "element vertex 0\nproperty float x\nproperty float x\n", "property 'x' is declared twice"},
      {ascii + "element vertex 0\nproperty quad x\n", "unknown type 'quad'"},
      {ascii + "element vertex 0\nproperty float\n", "has no name"},
      {ascii + "element vertex 0\nproperty list float int x\n", "length of a list"},
      {ascii + "elephant vertex 0\n", "unknown word 'elephant'"},
      {ascii + "end_header\n", "names no vertices"},
      {ascii + "element vertex 0\nproperty float x\nproperty float y\nend_header\n", "need the numbers x, y and z"},
      {ascii + "element vertex 0\nproperty float x\nproperty float y\nproperty list int int z\nend_header\n",
       "need the numbers x, y and z"},
      {ascii + vertices + "element face 0\nproperty float vertex_indices\nend_header\n", "need a list of integers"},
      {ascii + vertices + "element face 0\nproperty list int float vertex_indices\nend_header\n",
       "need a list of integers"},
      {ascii + vertices + "element face 0\nproperty list int int corners\nend_header\n", "need a list of integers"},
      {ascii + vertices + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n", "triangle strips"},
  };
  for (const auto& [content, problem] : cases) EXPECT_THAT(error_of("bad.ply", content), HasSubstr(problem));
}

TEST_F(Ply, names_line_and_problem_of_wrong_ascii_values) {
  const std::string header = kTriangleHeader;
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"0 0 0\n1 0", ":11: the file is truncated"},
      {vertices, "truncated"},
      {vertices + "3 0 1", ":13: the file is truncated"},
      {"0 0 zero\n1 0 0\n0 1 0\n3 0 1 2\n", ":10: 'zero' is not a number of type float"},
      {"0 0 1e999\n1 0 0\n0 1 0\n3 0 1 2\n", "'1e999' is not a number"},
      {"0 0 0x1\n1 0 0\n0 1 0\n3 0 1 2\n", "'0x1' is not a number"},
      {vertices + "3 0 1 3\n", ":13: face 0: vertex index 3 does not exist (3 vertices)"},
      {vertices + "3 0 1 -1\n", ":13: face 0: vertex index -1 does not exist"},
      {vertices + "3 0 1 1.5\n", "'1.5' is not a number of type int"},
      {vertices + "3 0 1 2147483648\n", "out of the range of type int"},
      {vertices + "300 0 1 2\n", "out of the range of type uchar"},
      {vertices + "-3 0 1 2\n", "out of the range of type uchar"},
      {vertices + "2 0 1\n", "face 0 has 2 vertices"},
      {vertices + "3 0 1 2\n3 0 1 2\n", ":14: 8 bytes follow the last element"},
  };
  for (const auto& [body, problem] : cases) EXPECT_THAT(error_of("bad.ply", header + body), HasSubstr(problem));
}

TEST_F(Ply, names_every_truncation_of_a_binary_file) {
  for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
    const std::string whole = binary<float, std::int32_t>(format, "float", "int", {{}, {}, {}, {}});
    const std::size_t body = whole.find("end_header\n") + std::string("end_header\n").size();
    for (std::size_t size = body; size < whole.size(); ++size) {
      EXPECT_THAT(error_of("bad.ply", whole.substr(0, size)), HasSubstr("truncated")) << size << " bytes";
    }
    EXPECT_NO_THROW(read("good.ply", whole));
    EXPECT_THAT(error_of("bad.ply", whole + "x"), HasSubstr("1 bytes follow the last element"));
  }
}

TEST_F(Ply, names_bytes_of_wrong_binary_values) {
  const std::vector<Vec3f> one_too_few = {{}, {}, {}};
  EXPECT_THAT(error_of("bad.ply", binary<float, std::int32_t>("binary_big_endian", "float", "int", one_too_few)),
              HasSubstr("face 1: vertex index 3 does not exist (3 vertices)"));
  std::string negative = binary<float, std::int32_t>("binary_little_endian", "float", "int", {{}, {}, {}, {}});
  const std::size_t last_corner = negative.size() - 2 - 4;
  negative.replace(last_corner, 4, "\xff\xff\xff\xff");
  EXPECT_THAT(error_of("bad.ply", negative), HasSubstr("face 1: vertex index -1 does not exist"));
  EXPECT_THAT(error_of("bad.ply", negative), HasSubstr(fmt::format(": byte {}: ", last_corner + 4)));
}

TEST_F(Ply, a_header_that_announces_more_than_the_file_holds_costs_no_memory) {
  EXPECT_THAT(error_of("bad.ply",
                       "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty double x\n"
                       "property double y\nproperty double z\nend_header\n0123456789"),
              HasSubstr("4000000000 'vertex' elements do not fit into the 10 bytes left"));
}

TEST_F(Ply, refuses_garbage) {
  std::string garbage;
  for (int i = 0; i < 1000; ++i) garbage += static_cast<char>(i * 7919 >> 3);
  EXPECT_THAT(error_of("bad.ply", garbage), HasSubstr("is neither PLY"));
  EXPECT_THAT(error_of("bad.ply", "ply\n" + garbage), HasSubstr("unknown word"));
  EXPECT_THAT(error_of("bad.ply", ""), HasSubstr("is neither PLY"));
}

TEST_F(Ply, with_very_many_properties_is_read_at_once) {
  constexpr int kProperties = 200000;
  std::string content = "ply\nformat ascii 1.0\n";
  for (int i = 0; i < kProperties; ++i) content += fmt::format("element empty{} 0\n", i);
  content += "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  for (int i = 0; i < kProperties; ++i) content += fmt::format("property float extra{}\n", i);
  content += "end_header\n1 2 3";
  for (int i = 0; i < kProperties; ++i) content += " 0";
  const std::clock_t begin = std::clock();
  const mesh_tools::Mesh mesh = read("many.ply", content + "\n");
  EXPECT_LT(std::clock() - begin, 5 * CLOCKS_PER_SEC);
  ASSERT_EQ(mesh.positions.size(), 1U);
  EXPECT_EQ(mesh.positions[0].z, 3.0);
}

TEST_F(Ply, names_files_that_cannot_be_read) {
  EXPECT_THROW(mesh_tools::read_mesh(folder_.file("absent.ply")), mesh_tools::MeshError);
  EXPECT_THROW(mesh_tools::read_mesh(folder_.file("")), mesh_tools::MeshError);
}

TEST_F(Ply, frames_of_one_mesh_have_the_same_triangles) {
  const mesh_tools::Mesh a = read("a.ply", std::string(kTriangleHeader) + "0 0 0 1 0 0 0 1 0 3 0 1 2\n");
  const mesh_tools::Mesh moved = read("b.ply", std::string(kTriangleHeader) + "0 0 1 1 0 1 0 1 1 3 0 1 2\n");
  EXPECT_NO_THROW(mesh_tools::require_same_topology(a, "a.ply", moved, "b.ply"));

  const auto difference = [&](const mesh_tools::Mesh& b) -> std::string {
    try {
      mesh_tools::require_same_topology(a, "a.ply", b, "b.ply");
    } catch (const mesh_tools::MeshError& error) {
      return error.what();
    }
    return "none";
  };
  mesh_tools::Mesh other = moved;
  other.triangles[0].v[2] = 0;
  EXPECT_EQ(difference(other), "b.ply: is not a frame of the same mesh as a.ply: triangle 0 has other vertices");
  other.triangles.push_back(other.triangles[0]);
  EXPECT_THAT(difference(other), HasSubstr("it has 2 triangles, not 1"));
  other.positions.pop_back();
  EXPECT_THAT(difference(other), HasSubstr("it has 2 vertices, not 3"));
}

}  // namespace
}  // namespace softcd::test
