#include "softcd/math/pseudo_normal.hpp"
#include "writing.hpp"

namespace softcd::mesh_tools {

std::string stl_of(const Mesh& mesh) {
  constexpr std::size_t kHeaderBytes = 80;  // which must not begin with "solid", as text files do
  constexpr std::size_t kTriangleBytes = 50;
  std::string bytes = "binary STL";
  bytes.reserve(kHeaderBytes + 4 + mesh.triangles.size() * kTriangleBytes);
  bytes.resize(kHeaderBytes, ' ');
  append_little_endian(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3d corners[3] = {mesh.positions[triangle.v[0]], mesh.positions[triangle.v[1]],
                              mesh.positions[triangle.v[2]]};
    append_vector(bytes, triangle_normal(corners));
    for (const Vec3d& corner : corners) append_vector(bytes, corner);
    bytes.append(2, '\0');  // no attributes
  }
  return bytes;
}

}  // namespace softcd::mesh_tools
