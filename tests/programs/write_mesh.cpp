#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mesh_tools/mesh_io.hpp"
#include "temporary_folder.hpp"

// Written files are read back by assimp, which is independent of the writers.
namespace softcd::test {
namespace {

using testing::HasSubstr;

/// Returns two triangles of a folded square, a sliver without area, and a vertex without triangles.
mesh_tools::Mesh some_mesh() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 2, 0.1}, {-1e-3, 2, 3}, {1e6, -7, 0.3}, {9, 9, 9}},
          {{{0, 1, 2}}, {{2, 1, 3}}, {{4, 4, 0}}}};
}

std::uint32_t number_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

class MeshWriting : public testing::Test {
 protected:
  std::string write(const std::string& name, const mesh_tools::Mesh& mesh) const {
    mesh_tools::write_mesh(folder_.file(name), mesh);
    return folder_.file(name);
  }

  std::string error_of(const std::string& name, const mesh_tools::Mesh& mesh) const {
    try {
      write(name, mesh);
    } catch (const mesh_tools::MeshError& error) {
      return error.what();
    }
    return "";
  }

  /// Returns the mesh that assimp reads; it lives as long as the test.
  const aiMesh& read(const std::string& file) {
    const aiScene* scene = importer_.ReadFile(file, 0);
    if (scene == nullptr || scene->mNumMeshes != 1) throw std::runtime_error(importer_.GetErrorString());
    return *scene->mMeshes[0];
  }

  TemporaryFolder folder_;
  Assimp::Importer importer_;
};

void expect_at(const aiVector3D& read, const Vec3d& written) {
  EXPECT_EQ(read.x, static_cast<float>(written.x));
  EXPECT_EQ(read.y, static_cast<float>(written.y));
  EXPECT_EQ(read.z, static_cast<float>(written.z));
}

TEST_F(MeshWriting, keeps_vertices_and_triangles_in_ply) {
  const mesh_tools::Mesh mesh = some_mesh();
  const aiMesh& read_back = read(write("mesh.ply", mesh));
  ASSERT_EQ(read_back.mNumVertices, mesh.positions.size());
  ASSERT_EQ(read_back.mNumFaces, mesh.triangles.size());
  for (unsigned i = 0; i < read_back.mNumVertices; ++i) expect_at(read_back.mVertices[i], mesh.positions[i]);
  for (unsigned f = 0; f < read_back.mNumFaces; ++f) {
    ASSERT_EQ(read_back.mFaces[f].mNumIndices, 3u);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(read_back.mFaces[f].mIndices[i], mesh.triangles[f].v[i]) << f;
  }
}

// By corners: since 5.3 assimp leaves out vertices that no triangle has.
TEST_F(MeshWriting, keeps_triangles_in_gltf) {
  const mesh_tools::Mesh mesh = some_mesh();
  const aiMesh& read_back = read(write("mesh.glb", mesh));
  ASSERT_EQ(read_back.mNumFaces, mesh.triangles.size());
  for (unsigned f = 0; f < read_back.mNumFaces; ++f) {
    ASSERT_EQ(read_back.mFaces[f].mNumIndices, 3u);
    for (int i = 0; i < 3; ++i) {
      expect_at(read_back.mVertices[read_back.mFaces[f].mIndices[i]], mesh.positions[mesh.triangles[f].v[i]]);
    }
  }
}

TEST_F(MeshWriting, gives_stl_corners_and_normals) {
  const mesh_tools::Mesh mesh = some_mesh();
  const aiMesh& read_back = read(write("mesh.stl", mesh));
  ASSERT_EQ(read_back.mNumFaces, mesh.triangles.size());
  for (unsigned f = 0; f < read_back.mNumFaces; ++f) {
    for (int i = 0; i < 3; ++i) {
      expect_at(read_back.mVertices[read_back.mFaces[f].mIndices[i]], mesh.positions[mesh.triangles[f].v[i]]);
    }
  }
  // The normal is that of (1, 0, 0) x (0, 2, 0.1); the sliver adds none.
  EXPECT_NEAR(read_back.mNormals[0].y, -0.1 / std::hypot(0.1, 2), 1e-7);
  EXPECT_NEAR(read_back.mNormals[0].z, 2 / std::hypot(0.1, 2), 1e-7);
  EXPECT_EQ(number_at(folder_.read("mesh.stl"), 84 + 2 * 50), 0u);
  EXPECT_EQ(folder_.read("mesh.stl").size(), 84 + 3 * 50u);
}

// Requirements of the standard that readers do not check: lengths, alignment and bounds. Readers may renumber elements.
TEST_F(MeshWriting, makes_gltf_of_two_chunks_with_bounds) {
  write("mesh.glb", some_mesh());
  const std::string bytes = folder_.read("mesh.glb");
  ASSERT_GT(bytes.size(), 28u);
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(number_at(bytes, 4), 2u);
  EXPECT_EQ(number_at(bytes, 8), bytes.size());
  const std::size_t description_bytes = number_at(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  EXPECT_EQ(description_bytes % 4, 0u);
  const std::size_t buffer_bytes = number_at(bytes, 20 + description_bytes);
  EXPECT_EQ(bytes.substr(24 + description_bytes, 4), std::string("BIN\0", 4));
  EXPECT_EQ(28 + description_bytes + buffer_bytes, bytes.size());

  const nlohmann::json description = nlohmann::json::parse(bytes.substr(20, description_bytes));
  EXPECT_EQ(description.at("buffers").at(0).at("byteLength"), buffer_bytes);
  const nlohmann::json& positions = description.at("accessors").at(0);
  EXPECT_EQ(positions.at("min").get<std::vector<float>>(), (std::vector<float>{-1e-3F, -7, 0}));
  EXPECT_EQ(positions.at("max").get<std::vector<float>>(), (std::vector<float>{1e6F, 9, 9}));
  ASSERT_EQ(positions.at("count"), 6);
  const std::size_t indices = 28 + description_bytes + 6 * 12;
  EXPECT_EQ(number_at(bytes, indices - 4), std::bit_cast<std::uint32_t>(9.0F));  // of the vertex that no triangle has
  const std::vector<std::uint32_t> vertices{0, 1, 2, 2, 1, 3, 4, 4, 0};
  ASSERT_EQ(bytes.size(), indices + 4 * vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) EXPECT_EQ(number_at(bytes, indices + 4 * i), vertices[i]) << i;
}

TEST_F(MeshWriting, refuses_what_a_format_cannot_hold) {
  mesh_tools::Mesh mesh = some_mesh();
  EXPECT_THAT(error_of("mesh.obj", mesh), HasSubstr("mesh.obj: ends in none of .ply, .stl, .glb"));
  EXPECT_THAT(error_of("missing/mesh.stl", mesh), HasSubstr("mesh.stl: cannot be written"));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    mesh.positions[3].y = bad;
    EXPECT_THAT(error_of("mesh.glb", mesh), HasSubstr("mesh.glb: cannot be glTF: vertex 3 is not finite"));
    EXPECT_EQ(error_of("mesh.ply", mesh), "");
  }
  EXPECT_THAT(error_of("mesh.glb", {}), HasSubstr("there are no triangles"));
}

}  // namespace
}  // namespace softcd::test
