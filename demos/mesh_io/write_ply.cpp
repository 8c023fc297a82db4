#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <fstream>
#include <string>

#include "mesh_io/mesh_io.hpp"

namespace softcd::demo {
namespace {

void append_little_endian(std::string& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xFFU));
}

}  // namespace

void write_ply(const std::filesystem::path& path, const Mesh& mesh) {
  std::string bytes = fmt::format(
      "ply\n"
      "format binary_little_endian 1.0\n"
      "element vertex {}\n"
      "property float x\n"
      "property float y\n"
      "property float z\n"
      "element face {}\n"
      "property list uchar uint vertex_indices\n"
      "end_header\n",
      mesh.positions.size(), mesh.triangles.size());
  for (const Vec3d& position : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      append_little_endian(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(position[axis])));
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    bytes.push_back(3);
    for (const std::uint32_t vertex : triangle.v) append_little_endian(bytes, vertex);
  }
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) throw MeshError(fmt::format("{}: cannot be written", path.string()));
}

}  // namespace softcd::demo
