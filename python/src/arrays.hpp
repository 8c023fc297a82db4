#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::python {

namespace nb = nanobind;

/// A caller's array, kept alive and in place.
using Array = nb::ndarray<nb::ro>;

/// Returns the name of the array's elements in numpy.
std::string dtype_name(const Array& array);

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

/// Positions of the same vertices in several environments.
struct PositionsOfCopies {
  Array memory;
  std::vector<Positions> of;  ///< of each environment
};

/// Reads positions of shape (copies, vertices, 3), as read_positions() does. Environments may be any distance apart:
/// numpy.broadcast_to shows one in all places.
PositionsOfCopies read_positions_of_copies(const char* name, nb::handle object, std::uint32_t copies,
                                           std::uint32_t vertices);

/// Throws InvalidInput where the library would leave out a coordinate in the CPU's memory. The text names the
/// environment if there is one.
void require_finite(const char* name, const Positions& positions, std::optional<std::uint32_t> environment = {});

/// Copies float32 or float64 of shape (n, 3) in the CPU's memory, as read_positions() reads them.
std::vector<Vec3d> read_points(const char* name, nb::handle object);

/// Reads integers of shape (n, 3), any strides, in the CPU's memory; lists, too.
std::vector<Triangle> read_triangles(const char* name, nb::handle object);
/// Reads integers of shape (n, 2), as read_triangles() does.
std::vector<Segment> read_segments(const char* name, nb::handle object);
/// Reads integers of shape (n,), as read_triangles() does.
std::vector<std::uint32_t> read_indices(const char* name, nb::handle object);

}  // namespace softcd::python
