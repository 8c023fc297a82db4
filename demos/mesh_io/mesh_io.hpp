#pragma once

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "softcd/core/types.hpp"

namespace softcd::demo {

struct Mesh {
  std::vector<Vec3d> positions;  ///< single-precision files hold their values exactly
  std::vector<Triangle> triangles;
};

/// A file that cannot be read as a mesh, or written; the text names the file, the place in it and the problem.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads PLY (ascii, binary of either endianness, any property types) or OBJ; which, the file's first line and
/// then its name say. Polygons become triangle fans. Indices are checked; positions may be NaN or infinite. Files and
/// pipes of up to 16 GiB are read. Throws MeshError.
Mesh read_mesh(const std::filesystem::path& path);

/// What the names of files that write_mesh writes end in.
constexpr std::array<std::string_view, 3> kWrittenExtensions = {".ply", ".stl", ".glb"};

/// Writes single precision, as binary PLY (little endian), as binary STL, in which each triangle has vertices of its
/// own, or as glTF 2.0 in one file (.glb), which must have triangles and finite positions; which, the name's end says.
/// Throws MeshError.
void write_mesh(const std::filesystem::path& path, const Mesh& mesh);

/// Throws MeshError, naming both files, when they are not two frames of one mesh: other vertex counts or triangles.
void require_same_topology(const Mesh& a, const std::filesystem::path& path_a, const Mesh& b,
                           const std::filesystem::path& path_b);

}  // namespace softcd::demo
