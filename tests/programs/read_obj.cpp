#include "mesh_reading.hpp"

namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using T = std::array<std::uint32_t, 3>;

class Obj : public MeshReading {};

TEST_F(Obj, reads_vertices_and_polygons) {
  const mesh_tools::Mesh mesh =
      read("mesh.obj",
           "# a comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 0.5\r\nv 0 1 .1 1 0 0\n"
           "v 0 0 -1e3 # behind\nvt 0 0\nvn 0 0 1\ns off\nusemtl red\n\nf 1 2 3\nf 1 2 3 4\n");
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.positions[2], (Vec3d{0, 1, 0.1}));
  EXPECT_EQ(mesh.positions[3], (Vec3d{0, 0, -1000}));
  EXPECT_THAT(triangles_of(mesh), ElementsAre(T{0, 1, 2}, T{0, 1, 2}, T{0, 2, 3}));
}

TEST_F(Obj, reads_every_form_of_index) {
  const mesh_tools::Mesh mesh = read("MESH.OBJ",
                                     "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2//2 3/3\nf -3 -2 -1\nv 2 2 2\nf -1 -2/7 1\n"
                                     "f 5 1 2\nv 3 3 3");
  EXPECT_THAT(triangles_of(mesh), ElementsAre(T{0, 1, 2}, T{0, 1, 2}, T{3, 2, 0}, T{4, 0, 1}));
  EXPECT_EQ(mesh.positions.size(), 5u);
}

TEST_F(Obj, an_empty_file_is_an_empty_mesh) {
  const mesh_tools::Mesh mesh = read("mesh.obj", "");
  EXPECT_TRUE(mesh.positions.empty());
  EXPECT_TRUE(mesh.triangles.empty());
}

TEST_F(Obj, names_line_and_problem) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"v 0 0\n", ":1: a vertex needs three coordinates"},
      {"v 0 0 up\n", ":1: 'up' is not a coordinate"},
      {vertices + "f 1 2\n", ":4: a face needs three vertices or more, not 2"},
      {vertices + "f 1 2 x\n", ":4: 'x' is not a vertex index"},
      {vertices + "f 1 2 /3\n", ":4: '/3' is not a vertex index"},
      {vertices + "f 1 2 0\n", ":4: vertex index 0 does not exist"},
      {vertices + "f 1 2 -4\n", ":4: vertex index -4 does not exist (3 vertices so far)"},
      {vertices + "f 1 2 3\nf 1 2 4\n", ":5: vertex index 4 does not exist (3 vertices)"},
      {vertices + "f 1 2 4294967296\n", ":4: vertex index 4294967296 is too large"},
      {vertices + "f 1 2 99999999999999999999\n", "is not a vertex index"},
      {"hello world\n", ":1: unknown statement 'hello'"},
      {"curv 0 1 1 2\n", "free-form geometry"},
      {std::string("v 0 0 0\nv 0\0 0", 14), ":2: is not text"},
  };
  for (const auto& [content, problem] : cases) EXPECT_THAT(error_of("bad.obj", content), HasSubstr(problem));
}

TEST_F(Obj, large_files_are_read_whole) {
  std::string content = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  constexpr std::size_t kFaces = 300000;  // of 8 bytes: several blocks
  for (std::size_t i = 0; i < kFaces; ++i) content += "f 1 2 3\n";
  EXPECT_EQ(read("large.obj", content).triangles.size(), kFaces);
}

TEST_F(Obj, files_beyond_all_meshes_are_refused_unread) {
  const std::string file = folder_.write("huge.obj", "");
  std::filesystem::resize_file(file, (std::uintmax_t{1} << 34) + 1);
  try {
    mesh_tools::read_mesh(file);
    FAIL() << "this was read";
  } catch (const mesh_tools::MeshError& error) {
    EXPECT_EQ(error.what(), file + ": is larger than 16 GiB");
  }
}

TEST_F(Obj, is_known_by_its_name_only) {
  EXPECT_THAT(error_of("mesh.txt", "v 0 0 0\n"), HasSubstr("is neither PLY"));
}

}  // namespace
}  // namespace softcd::test
