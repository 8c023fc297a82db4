#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "writing.hpp"

// glTF 2.0 (ISO/IEC 12113), its sections 3.6 (accessors) and 4 (the binary container).
namespace softcd::mesh_tools {
namespace {

constexpr std::uint64_t kVectorBytes = 12;  // of a position, and of a triangle's three indices

std::array<float, 3> floats_of(const Vec3d& position) {
  return {static_cast<float>(position.x), static_cast<float>(position.y), static_cast<float>(position.z)};
}

/// Checks that there are numbers and that all are finite, as glTF requires.
void check(const std::string& name, const Mesh& mesh) {
  const auto refuse = [&name](const std::string& problem) {
    throw MeshError(fmt::format("{}: cannot be glTF: {}", name, problem));
  };
  if (mesh.triangles.empty()) refuse("there are no triangles");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (const float coordinate : floats_of(mesh.positions[i])) {
      if (!std::isfinite(coordinate)) refuse(fmt::format("vertex {} is not finite", i));
    }
  }
  constexpr std::uint64_t kMostBufferBytes =
      std::numeric_limits<std::uint32_t>::max() - 4096;  // beside the description
  if (kVectorBytes * (mesh.positions.size() + mesh.triangles.size()) > kMostBufferBytes)
    refuse("it would exceed 4 GiB");
}

/// Returns the description of one mesh at the origin. The only buffer holds its positions and then its indices.
nlohmann::json description_of(const Mesh& mesh) {
  constexpr int kUnsignedInt = 5125, kFloat = 5126, kArrayBuffer = 34962, kElementArrayBuffer = 34963;
  std::array<float, 3> least = floats_of(mesh.positions[0]);
  std::array<float, 3> most = least;
  for (const Vec3d& position : mesh.positions) {
    const std::array<float, 3> x = floats_of(position);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], x[axis]);
      most[axis] = std::max(most[axis], x[axis]);
    }
  }
  using nlohmann::json;
  const std::uint64_t position_bytes = kVectorBytes * mesh.positions.size();
  const std::uint64_t index_bytes = kVectorBytes * mesh.triangles.size();
  const json primitive = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
  const json positions = {
      {"bufferView", 0}, {"componentType", kFloat}, {"count", mesh.positions.size()}, {"type", "VEC3"}, {"min", least},
      {"max", most}};
  const json indices = {
      {"bufferView", 1}, {"componentType", kUnsignedInt}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}};
  const json position_view = {{"buffer", 0}, {"byteLength", position_bytes}, {"target", kArrayBuffer}};
  const json index_view = {
      {"buffer", 0}, {"byteOffset", position_bytes}, {"byteLength", index_bytes}, {"target", kElementArrayBuffer}};
  return {{"asset", {{"version", "2.0"}, {"generator", "softcd"}}},
          {"scene", 0},
          {"scenes", json::array({{{"nodes", json::array({0})}}})},
          {"nodes", json::array({{{"mesh", 0}}})},
          {"meshes", json::array({{{"primitives", json::array({primitive})}}})},
          {"buffers", json::array({{{"byteLength", position_bytes + index_bytes}}})},
          {"bufferViews", json::array({position_view, index_view})},
          {"accessors", json::array({positions, indices})}};
}

}  // namespace

std::string glb_of(const std::string& name, const Mesh& mesh) {
  constexpr std::uint32_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
  check(name, mesh);
  std::string description = description_of(mesh).dump();
  description.append((4 - description.size() % 4) % 4, ' ');
  const auto description_bytes = static_cast<std::uint32_t>(description.size());
  const auto buffer_bytes = static_cast<std::uint32_t>(kVectorBytes * (mesh.positions.size() + mesh.triangles.size()));

  std::string bytes = "glTF";
  append_little_endian(bytes, 2);
  append_little_endian(bytes, kHeaderBytes + 2 * kChunkHeaderBytes + description_bytes + buffer_bytes);
  append_little_endian(bytes, description_bytes);
  bytes += "JSON" + description;
  append_little_endian(bytes, buffer_bytes);
  bytes.append("BIN\0", 4);
  for (const Vec3d& position : mesh.positions) append_vector(bytes, position);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle.v) append_little_endian(bytes, vertex);
  }
  return bytes;
}

}  // namespace softcd::mesh_tools
