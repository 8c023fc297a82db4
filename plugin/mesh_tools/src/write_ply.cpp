#include <fmt/format.h>

#include "writing.hpp"

namespace softcd::mesh_tools {

std::string ply_of(const Mesh& mesh) {
  std::string bytes = fmt::format(
      "ply\n"
      "format binary_little_endian 1.0\n"
      "element vertex {}\n"
      "property float x\n"
      "property float y\n"
      "property float z\n"
      "element face {}\n"
      "property list uchar uint vertex_indices\n"
      "{}"
      "end_header\n",
      mesh.positions.size(), mesh.triangles.size(),
      mesh.colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n");
  for (const Vec3d& position : mesh.positions) append_vector(bytes, position);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bytes.push_back(3);
    for (const std::uint32_t vertex : mesh.triangles[t].v) append_little_endian(bytes, vertex);
    if (mesh.colours.empty()) continue;
    for (const std::uint8_t part : mesh.colours[t]) bytes.push_back(static_cast<char>(part));
  }
  return bytes;
}

}  // namespace softcd::mesh_tools
