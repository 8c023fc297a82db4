#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "mesh_reading.hpp"

namespace softcd::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string bytes_of(std::uint32_t number) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> 8 * i & 255);
  return bytes;
}

std::string glb(const json& description, std::string buffer) {
  std::string text = description.dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  buffer.append((4 - buffer.size() % 4) % 4, '\0');
  return "glTF" + bytes_of(2) + bytes_of(static_cast<std::uint32_t>(28 + text.size() + buffer.size())) +
         bytes_of(static_cast<std::uint32_t>(text.size())) + "JSON" + text +
         bytes_of(static_cast<std::uint32_t>(buffer.size())) + std::string("BIN\0", 4) + buffer;
}

/// A tetrahedron, whose faces have corners of their own, each with its normal.
class GltfReading : public MeshReading {
 protected:
  GltfReading() {
    const float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int corners[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    for (const int corner : corners) {
      buffer_.append(reinterpret_cast<const char*>(points[corner]), 12);
      buffer_.append(12, '\1');  // some normal
    }
    for (char i = 0; i < 12; ++i) buffer_ += {i, '\0'};
    description_ = json::parse(R"({
      "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 12},
                    {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "type": "VEC3", "count": 12},
                    {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 12}],
      "bufferViews": [{"buffer": 0, "byteLength": 288, "byteStride": 24},
                      {"buffer": 0, "byteOffset": 288, "byteLength": 24}],
      "buffers": [{"byteLength": 312}]})");
  }

  mesh_tools::Mesh read_description() const { return read("mesh.glb", glb(description_, buffer_)); }
  std::string error() const { return error_of("mesh.glb", glb(description_, buffer_)); }

  json description_;
  std::string buffer_;
};

TEST_F(GltfReading, joins_corners_with_normals_to_a_closed_mesh) {
  const mesh_tools::Mesh mesh = read_description();
  EXPECT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) edges.insert({t.v[i], t.v[(i + 1) % 3]});
  }
  EXPECT_EQ(edges.size(), 12u);
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a})) << a << ' ' << b;
}

TEST_F(GltfReading, keeps_positions_apart_that_differ_by_one_bit) {
  const std::uint32_t least_float = 1;
  std::memcpy(buffer_.data(), &least_float, 4);
  EXPECT_EQ(read_description().positions.size(), 5u);
}

TEST_F(GltfReading, applies_transforms_of_nodes_and_keeps_the_outside) {
  description_["nodes"] = json::parse(
      R"([{"children": [1, 2], "translation": [10, 0, 0]},
          {"mesh": 0, "rotation": [0, 0, 1, 0], "scale": [2, 1, 1]},
          {"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}])");
  const mesh_tools::Mesh mesh = read_description();
  ASSERT_EQ(mesh.positions.size(), 8u) << "two meshes become one";
  EXPECT_EQ(mesh.positions[1], (Vec3d{10, -1, 0}));
  EXPECT_EQ(mesh.positions[2], (Vec3d{8, 0, 0}));
  EXPECT_EQ(mesh.positions[6], (Vec3d{9, 0, 5}));
  EXPECT_EQ(triangles_of(mesh)[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(triangles_of(mesh)[4], (std::array<std::uint32_t, 3>{4, 6, 5})) << "the mirrored mesh";
}

TEST_F(GltfReading, refuses_what_it_would_misplace) {
  const json whole = description_;
  const std::map<std::string, std::pair<json::json_pointer, json>> changes = {
      {"needs the glTF extension 'KHR_mesh_quantization'",
       {json::json_pointer("/extensionsRequired"), {"KHR_mesh_quantization"}}},
      {"is animated", {json::json_pointer("/animations"), json::array({json::object()})}},
      {"is moved by a skeleton", {json::json_pointer("/nodes/0/skin"), 0u}},
      {"has morph targets", {json::json_pointer("/meshes/0/primitives/0/targets"), json::array()}},
      {"has triangle strips or fans", {json::json_pointer("/meshes/0/primitives/0/mode"), 5u}},
      {"positions that are not three floats", {json::json_pointer("/accessors/0/componentType"), 5122u}},
      {"sparse accessors", {json::json_pointer("/accessors/0/sparse"), json::object()}},
      {"in another file", {json::json_pointer("/buffers/0/uri"), "mesh.bin"}},
      {"a node with two parents", {json::json_pointer("/nodes/0/children"), {0u}}},
      {"a buffer view beyond its buffer", {json::json_pointer("/bufferViews/1/byteLength"), 25u}},
      {"an accessor beyond its buffer view", {json::json_pointer("/accessors/0/count"), 13u}},
      {"no multiple of three", {json::json_pointer("/accessors/2/count"), 11u}},
      {"vertex index 11 does not exist (11 vertices)", {json::json_pointer("/accessors/0/count"), 11u}},
      {"index, count or offset that is none", {json::json_pointer("/nodes/0/mesh"), -1}},
      {"is no valid glTF", {json::json_pointer("/scenes"), json::array()}},
      {"is not glTF 2.0", {json::json_pointer("/asset/version"), "1.0"}}};
  for (const auto& [problem, change] : changes) {
    description_ = whole;
    description_[change.first] = change.second;
    EXPECT_THAT(error(), HasSubstr(problem));
  }
}

TEST_F(GltfReading, refuses_every_part_of_a_file) {
  const std::string whole = glb(description_, buffer_);
  for (std::size_t size = 4; size < whole.size(); ++size) error_of("part.glb", whole.substr(0, size));
}

}  // namespace
}  // namespace softcd::test
