#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

#include "mesh_io/parsing.hpp"

namespace softcd::demo {
namespace {

std::string read_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw MeshError(fmt::format("{}: is a folder", path.string()));
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
    throw MeshError(fmt::format("{}: cannot be opened (does it exist, and may you read it?)", path.string()));
  std::string content(std::istreambuf_iterator<char>(stream), {});
  if (stream.bad()) throw MeshError(fmt::format("{}: reading failed", path.string()));
  return content;
}

bool has_obj_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".obj";
}

bool same_triangle(const Triangle& a, const Triangle& b) {
  return std::equal(a.v, a.v + 3, b.v);
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
  const std::string content = read_file(path);
  std::string_view rest = content;
  if (take_line(rest) == "ply") return read_ply(path.string(), content);
  if (has_obj_extension(path)) return read_obj(path.string(), content);
  throw MeshError(fmt::format("{}: is neither PLY (first line 'ply') nor OBJ (name ending in .obj)", path.string()));
}

void require_same_topology(const Mesh& a, const std::filesystem::path& path_a, const Mesh& b,
                           const std::filesystem::path& path_b) {
  const auto require = [&](bool same, const std::string& difference) {
    if (!same) {
      throw MeshError(
          fmt::format("{}: is not a frame of the same mesh as {}: {}", path_b.string(), path_a.string(), difference));
    }
  };
  require(a.positions.size() == b.positions.size(),
          fmt::format("it has {} vertices, not {}", b.positions.size(), a.positions.size()));
  require(a.triangles.size() == b.triangles.size(),
          fmt::format("it has {} triangles, not {}", b.triangles.size(), a.triangles.size()));
  const auto differing = std::mismatch(a.triangles.begin(), a.triangles.end(), b.triangles.begin(), same_triangle);
  require(differing.first == a.triangles.end(),
          fmt::format("triangle {} has other vertices", differing.first - a.triangles.begin()));
}

}  // namespace softcd::demo
