#pragma once

#include <bit>
#include <cstdint>
#include <string>

#include "mesh_tools/mesh_io.hpp"

namespace softcd::mesh_tools {

inline void append_little_endian(std::string& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xFFU));
}

/// Appends three floats.
inline void append_vector(std::string& bytes, const Vec3d& vector) {
  for (int axis = 0; axis < 3; ++axis) {
    append_little_endian(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(vector[axis])));
  }
}

// Return the whole content of a file. `name` is for error messages, in MeshErrors.
std::string ply_of(const Mesh& mesh);
std::string stl_of(const Mesh& mesh);
std::string glb_of(const std::string& name, const Mesh& mesh);

}  // namespace softcd::mesh_tools
