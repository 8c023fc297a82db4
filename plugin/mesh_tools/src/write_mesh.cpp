#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>

#include "writing.hpp"

namespace softcd::mesh_tools {
namespace {

std::string content_of(const std::filesystem::path& path, const Mesh& mesh) {
  const std::string extension = path.extension().string();
  if (extension == ".ply") return ply_of(mesh);
  if (extension == ".stl") return stl_of(mesh);
  if (extension == ".glb") return glb_of(path.string(), mesh);
  throw MeshError(fmt::format("{}: ends in none of {}", path.string(), fmt::join(kWrittenExtensions, ", ")));
}

}  // namespace

void write_mesh(const std::filesystem::path& path, const Mesh& mesh) {
  const std::string content = content_of(path, mesh);
  std::ofstream stream(path, std::ios::binary);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) throw MeshError(fmt::format("{}: cannot be written", path.string()));
}

}  // namespace softcd::mesh_tools
