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

/// Positions of shape (n, 3), in the CPU's memory or a GPU's: anything with the buffer protocol, `__dlpack__` or
/// `__cuda_array_interface__`. Float32 and float64 are read where they are if each row's three lie side by side and the
/// rows follow each other. Anything else that numpy reads as real numbers, lists among it, is copied. Throws
/// nb::type_error or InvalidInput, which begin with `name`.
PositionsArray read_positions(const char* name, nb::handle object);

/// Throws InvalidInput where a coordinate in the CPU's memory is one that the library leaves out.
void require_finite(const char* name, const Positions& positions);

/// Float32 or float64 of shape (n, 3) in the CPU's memory, as read_positions() reads them, copied.
std::vector<Vec3d> read_points(const char* name, nb::handle object);

/// Integers of shape (n, 3), any strides, in the CPU's memory; lists, too.
std::vector<Triangle> read_triangles(const char* name, nb::handle object);
/// The same of shape (n, 2).
std::vector<Segment> read_segments(const char* name, nb::handle object);
/// The same of shape (n,).
std::vector<std::uint32_t> read_indices(const char* name, nb::handle object);

}  // namespace softcd::python
