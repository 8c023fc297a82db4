#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::python {

namespace nb = nanobind;

/// A caller's array, kept alive and in place.
using Array = nb::ndarray<nb::ro>;

/// Positions in a caller's memory.
struct PositionsArray {
  Array memory;
  Positions positions;
};

/// Reads positions of shape (n, 3), in the CPU's memory or a GPU's, from anything with the buffer protocol,
/// `__dlpack__` or `__cuda_array_interface__`. Float32 and float64 are read in place if each row's three coordinates
/// are contiguous and rows follow each other. Other objects that numpy reads as real numbers, such as lists, are
/// copied. Throws nb::type_error or InvalidInput; the text begins with `name`.
PositionsArray read_positions(const char* name, nb::handle object);

/// Throws InvalidInput where the library would leave out a coordinate in the CPU's memory.
void require_finite(const char* name, const Positions& positions);

/// Copies float32 or float64 of shape (n, 3) in the CPU's memory, as read_positions() reads them.
std::vector<Vec3d> read_points(const char* name, nb::handle object);

/// Reads integers of shape (n, 3), any strides, in the CPU's memory; lists, too.
std::vector<Triangle> read_triangles(const char* name, nb::handle object);
/// Reads integers of shape (n, 2), as read_triangles() does.
std::vector<Segment> read_segments(const char* name, nb::handle object);
/// Reads integers of shape (n,), as read_triangles() does.
std::vector<std::uint32_t> read_indices(const char* name, nb::handle object);

}  // namespace softcd::python
