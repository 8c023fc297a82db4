#pragma once

#include <filesystem>
#include <stdexcept>
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

/// Writes binary PLY (little endian, single precision). Throws MeshError.
void write_ply(const std::filesystem::path& path, const Mesh& mesh);

/// Throws MeshError, naming both files, when they are not two frames of one mesh: other vertex counts or triangles.
void require_same_topology(const Mesh& a, const std::filesystem::path& path_a, const Mesh& b,
                           const std::filesystem::path& path_b);

}  // namespace softcd::demo
