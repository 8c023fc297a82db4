#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "mesh_io/mesh_io.hpp"
#include "owned_arrays.hpp"
#include "program.hpp"
#include "scenes/exact_intersection.hpp"

namespace softcd::python {
namespace {

nb::tuple read_mesh(const std::filesystem::path& path) {
  demo::Mesh mesh;
  {
    const nb::gil_scoped_release no_interpreter;
    mesh = demo::read_mesh(path);
  }
  return nb::make_tuple(own<double, 3>(std::move(mesh.positions)), own<std::uint32_t, 3>(std::move(mesh.triangles)));
}

using Doubles = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using EdgeIndices = nb::ndarray<const std::uint32_t, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using TriangleIndices = nb::ndarray<const std::uint32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

nb::object edges_meet_triangles(const Doubles& vertices, const EdgeIndices& edges, const TriangleIndices& triangles) {
  if (edges.shape(0) != triangles.shape(0)) throw InvalidInput("edges and triangles: expected as many of each");
  std::vector<std::uint8_t> meet(edges.shape(0));
  {
    const nb::gil_scoped_release no_interpreter;
    const auto at = [&](std::uint32_t v) {
      if (v >= vertices.shape(0)) throw InvalidInput("edges and triangles: an index has no vertex");
      const double* const x = vertices.data() + 3 * static_cast<std::size_t>(v);
      return Vec3d{x[0], x[1], x[2]};
    };
    for (std::size_t i = 0; i < meet.size(); ++i) {
      const std::uint32_t* const e = edges.data() + 2 * i;
      const std::uint32_t* const t = triangles.data() + 3 * i;
      meet[i] = demo::intersects(at(e[0]), at(e[1]), {at(t[0]), at(t[1]), at(t[2])}) ? 1 : 0;
    }
  }
  return own<std::uint8_t, 1>(std::move(meet)).attr("ravel")().attr("astype")("bool");
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
      "Reads a PLY or OBJ file: vertices as float64 of shape (n, 3), triangles as uint32 of shape (m, 3). Polygons "
      "become triangle fans. Raises MeshError, naming the file and the place in it.");
  module.def("edges_meet_triangles", &edges_meet_triangles, "vertices"_a, "edges"_a, "triangles"_a,
             "Whether each edge and the triangle beside it have a point in common, decided exactly.");
  module.def("detect_program", &detect_program, "arguments"_a, "softcd-detect: its exit code.");
}

}  // namespace softcd::python
