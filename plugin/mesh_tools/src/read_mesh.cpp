#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string>
#include <system_error>

#include "parsing.hpp"

// The readers are softcd's own, because those in Debian 12 were not better: tinyobjloader 2.0 rc10 and, also for PLY,
// assimp 5.2.5. A million triangles on x86-64 take, in seconds of processor time and MB of memory:
//
//          ours           tinyobjloader   assimp
//     OBJ  0.40 s,  92    0.53 s, 182     2.09 s, 574
//     PLY  0.04 s,  49                    1.00 s, 371
//
// tinyobjloader silently accepts vertices of two coordinates, faces of two vertices and text that is no OBJ. It
// returned indices beyond the vertices for 405 of 2000 damaged files. assimp accepts faces of two vertices, and names
// no line. softcd's readers reject all of these, and name line and problem.
namespace softcd::mesh_tools {
namespace {

namespace fs = std::filesystem;

// A limit for endless input, far above the meshes that a detection could hold.
constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 34;
constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

bool has_obj_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".obj";
}

bool same_triangle(const Triangle& a, const Triangle& b) {
  return std::equal(a.v, a.v + 3, b.v);
}

}  // namespace

std::string read_mesh_content(const fs::path& path) {
  const auto require = [&](bool condition, const char* problem) {
    if (!condition) throw MeshError(fmt::format("{}: {}", path.string(), problem));
  };
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  require(!fs::is_directory(status), "is a folder");
  require(fs::is_regular_file(status) || fs::is_fifo(status) || !fs::exists(status), "is neither a file nor a pipe");
  std::ifstream stream(path, std::ios::binary);
  require(stream.good(), "cannot be opened (does it exist, and may you read it?)");

  // The size of a pipe is known only at its end.
  bool is_too_large = fs::is_regular_file(status) && fs::file_size(path, ignored) > kMostBytes;
  std::string content;
  while (!is_too_large && stream) {
    const std::size_t offset = content.size();
    content.resize(offset + kBlockBytes);
    stream.read(content.data() + offset, kBlockBytes);
    content.resize(offset + static_cast<std::size_t>(stream.gcount()));
    is_too_large = content.size() > kMostBytes;
  }
  require(!is_too_large, "is larger than 16 GiB");
  require(!stream.bad(), "cannot be read");
  return content;
}

Mesh parse_mesh(const fs::path& path, std::string_view content) {
  std::string_view rest = content;
  if (take_line(rest) == "ply") return read_ply(path.string(), content);
  if (content.starts_with("glTF")) return read_gltf(path.string(), content);
  if (has_obj_extension(path)) return read_obj(path.string(), content);
  throw MeshError(fmt::format(
      "{}: is neither PLY (first line 'ply') nor OBJ (name ending in .obj) nor binary glTF (.glb)", path.string()));
}

Mesh read_mesh(const fs::path& path) {
  return parse_mesh(path, read_mesh_content(path));
}

void require_same_topology(const Mesh& a, const fs::path& path_a, const Mesh& b, const fs::path& path_b) {
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

}  // namespace softcd::mesh_tools
