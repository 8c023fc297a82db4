#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "softcd/core/types.hpp"

namespace softcd::mesh_tools {

using Rgb = std::array<std::uint8_t, 3>;

struct Mesh {
  std::vector<Vec3d> positions;  ///< single-precision files hold their values exactly
  std::vector<Triangle> triangles;
  std::vector<Rgb> colours = {};  ///< of the triangles, or empty; only PLY files are written with them
};

/// Thrown when a file cannot be read as a mesh, or written. The text names the file, the place in it and the problem.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads PLY (ascii, binary of either endianness, any property types), OBJ or glTF 2.0 in one file (.glb). The file's
/// first line and its name decide the format. Polygons become triangle fans. Indices are checked; positions may be NaN
/// or infinite, except in glTF. Reads files and pipes of up to 16 GiB. Throws MeshError.
///
/// The scene of a glTF file becomes one mesh, with its nodes' transforms applied in double. Vertices at exactly the
/// same position are joined, because the format stores a vertex once for each of its normals and colours.
Mesh read_mesh(const std::filesystem::path& path);

/// Returns the content of a file or pipe of up to 16 GiB, as read_mesh() reads it. Throws MeshError.
std::string read_mesh_content(const std::filesystem::path& path);

/// Reads a mesh from a file's content, as read_mesh() does. The path decides the format, with the first line, and is
/// the name in messages. Throws MeshError.
Mesh parse_mesh(const std::filesystem::path& path, std::string_view content);

/// The extensions of files that write_mesh writes.
constexpr std::array<std::string_view, 3> kWrittenExtensions = {".ply", ".stl", ".glb"};

/// Writes a mesh in single precision. The extension of the name decides the format:
/// - .ply: binary PLY (little endian)
/// - .stl: binary STL, in which no triangles share vertices
/// - .glb: glTF 2.0 in one file; the mesh must have triangles and finite positions
///
/// Throws MeshError.
void write_mesh(const std::filesystem::path& path, const Mesh& mesh);

/// Throws MeshError, naming both files, unless they are two frames of one mesh: the vertex counts and triangles must
/// agree.
void require_same_topology(const Mesh& a, const std::filesystem::path& path_a, const Mesh& b,
                           const std::filesystem::path& path_b);

}  // namespace softcd::mesh_tools
