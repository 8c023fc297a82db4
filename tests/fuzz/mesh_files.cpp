#include <new>

#include "bytes.hpp"
#include "parsing.hpp"

// Any file gives a mesh with valid indices, or an error of one line that names the file.

namespace {

using softcd::test::require;

template <class Read>
void read_or_refuse(const Read& read, std::string_view content) {
  try {
    const softcd::mesh_tools::Mesh mesh = read("a file", content);
    for (const softcd::Triangle& triangle : mesh.triangles) {
      for (const std::uint32_t v : triangle.v) require(v < mesh.positions.size(), "indices are those of vertices");
    }
    require(mesh.positions.size() + mesh.triangles.size() <= content.size(), "a mesh is no larger than its file");
  } catch (const softcd::mesh_tools::MeshError& error) {
    const std::string_view text = error.what();
    require(text.starts_with("a file:"), "errors name the file");
    require(text.find('\n') == std::string_view::npos, "errors are one line");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view content(reinterpret_cast<const char*>(data), size);
  std::string_view rest = content;
  if (softcd::mesh_tools::take_line(rest) == "ply") {
    read_or_refuse(softcd::mesh_tools::read_ply, content);
  } else {
    read_or_refuse(softcd::mesh_tools::read_obj, content);
  }
  return 0;
}
