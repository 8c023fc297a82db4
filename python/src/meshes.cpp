#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "keywords.hpp"
#include "mesh_tools/mesh_io.hpp"
#include "mesh_tools/triangle_meeting.hpp"
#include "owned_arrays.hpp"
#include "program.hpp"

namespace softcd::python {
namespace {

nb::tuple read_mesh(const std::filesystem::path& path) {
  mesh_tools::Mesh mesh;
  {
    const nb::gil_scoped_release no_interpreter;
    mesh = mesh_tools::read_mesh(path);
  }
  return nb::make_tuple(own<double, 3>(std::move(mesh.positions)), own<std::uint32_t, 3>(std::move(mesh.triangles)));
}

void write_mesh(const std::filesystem::path& path, nb::handle vertices, nb::handle triangles) {
  const mesh_tools::Mesh mesh{read_points("vertices", vertices), read_triangles("triangles", triangles)};
  const nb::gil_scoped_release no_interpreter;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t vertex : mesh.triangles[t].v) {
      if (vertex < mesh.positions.size()) continue;
      throw InvalidInput(fmt::format("triangles: row {} has the index {}, but there are {} vertices", t, vertex,
                                     mesh.positions.size()));
    }
  }
  mesh_tools::write_mesh(path, mesh);
}

using Doubles = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using TriangleIndices = nb::ndarray<const std::uint32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Begins = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<const std::uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

mesh_tools::Face face_of(const Doubles& vertices, const TriangleIndices& triangles, std::size_t t) {
  mesh_tools::Face face{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t v = triangles(t, i);
    if (v >= vertices.shape(0)) throw InvalidInput("triangles: an index has no vertex");
    face.v[i] = v;
    face.x[i] = {vertices(v, 0), vertices(v, 1), vertices(v, 2)};
  }
  return face;
}

/// Compares triangle first + i with the candidates from begins[i] up to begins[i + 1] that come after it.
nb::object intersecting_pairs(const Doubles& vertices, const TriangleIndices& triangles, std::size_t first,
                              const Begins& begins, const Indices& candidates) {
  const std::size_t count = std::max<std::size_t>(begins.shape(0), 1) - 1;
  if (first > triangles.shape(0) || count > triangles.shape(0) - first) throw InvalidInput("begins: too many rows");
  std::vector<std::array<std::uint32_t, 2>> pairs;
  {
    const nb::gil_scoped_release no_interpreter;
    for (std::size_t i = 0; i < count; ++i) {
      const mesh_tools::Face a = face_of(vertices, triangles, first + i);
      for (std::int64_t j = begins(i); j < begins(i + 1); ++j) {
        if (j < 0 || static_cast<std::size_t>(j) >= candidates.shape(0))
          throw InvalidInput("begins: not in candidates");
        const std::uint32_t other = candidates(static_cast<std::size_t>(j));
        if (other <= first + i) continue;
        if (other >= triangles.shape(0)) throw InvalidInput("candidates: an index has no triangle");
        const mesh_tools::Face b = face_of(vertices, triangles, other);
        if (mesh_tools::meeting_of(a, b) == mesh_tools::Meeting::apart) continue;
        pairs.push_back({static_cast<std::uint32_t>(first + i), other});
      }
    }
  }
  return own<std::uint32_t, 2>(std::move(pairs));
}

int detect_program(const std::vector<nb::bytes>& arguments) {
  std::vector<std::string> words;
  words.reserve(arguments.size());
  for (const nb::bytes& argument : arguments) words.emplace_back(argument.c_str(), argument.size());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const nb::gil_scoped_release no_interpreter;
  return demo::detect_program(static_cast<int>(words.size()), pointers.data());
}

}  // namespace

void bind_meshes(nb::module_& module) {
  using namespace nb::literals;
  module.def(
      "read_mesh", &read_mesh, "path"_a,
      nb::sig("def read_mesh(path: str | os.PathLike[str]) -> tuple[numpy.ndarray, numpy.ndarray]"),
      "Reads a PLY, OBJ or GLB file: vertices as float64 of shape (n, 3), triangles as uint32 of shape (m, 3). "
      "Polygons become triangle fans. Vertices of GLB files at the same position are joined. Raises MeshError, naming "
      "the file and the problem.");
  module.def("write_mesh", &write_mesh, "path"_a, "vertices"_a, "triangles"_a,
             nb::sig("def write_mesh(path: str | os.PathLike[str], vertices: object, triangles: object) -> None"),
             "Writes vertices of shape (n, 3) and triangles of shape (m, 3) in single precision: a PLY, STL or GLB "
             "file, as the "
             "name ends. Raises MeshError, naming the file.");
  module.def("intersecting_pairs", &intersecting_pairs, "vertices"_a, "triangles"_a, "first"_a, "begins"_a,
             "candidates"_a,
             nb::sig("def intersecting_pairs(vertices: numpy.ndarray, triangles: numpy.ndarray, first: int, "
                     "begins: numpy.ndarray, candidates: numpy.ndarray) -> numpy.typing.NDArray[numpy.uint32]"),
             "Returns which of the triangles from the first on intersect which of their candidates, decided exactly.");
  module.def("refuse_keyword", &refuse_keyword, "function"_a, "keyword"_a, "known"_a,
             "Raises TypeError, which names the most similar keyword.");
  module.def("detect_program", &detect_program, "arguments"_a, "Runs softcd-detect and returns its exit code.");
}

}  // namespace softcd::python
