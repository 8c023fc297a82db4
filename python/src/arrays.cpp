#include "arrays.hpp"

#include <fmt/format.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace softcd::python {

std::string dtype_name(const Array& array) {
  constexpr const char* kKinds[] = {"int", "uint", "float", "handle", "bfloat", "complex", "bool"};
  const std::uint8_t code = array.dtype().code;
  const std::string kind = code < std::size(kKinds) ? kKinds[code] : "dtype";
  return array.dtype().lanes == 1 ? fmt::format("{}{}", kind, array.dtype().bits) : "vectors of several lanes";
}

namespace {

constexpr double kLargestCoordinate = 1e37;  // the limit of Positions

std::string name_of_type(nb::handle object) {
  return nb::cast<std::string>(nb::str(nb::handle(object.type()).attr("__name__")));
}

/// Returns why an object with __dlpack__ does not give access to its memory.
std::string dlpack_problem(nb::handle object) {
  if (!nb::hasattr(object, "__dlpack__")) return "";
  try {
    object.attr("__dlpack__")();
  } catch (const nb::python_error& error) {
    return fmt::format(": {}", nb::cast<std::string>(nb::str(error.value())));
  }
  return "";
}

nb::builtin_exception wrong_type(const char* name, nb::handle object, const char* expected) {
  return nb::type_error(fmt::format("{}: expected {}, got {} that cannot be read as such{}", name, expected,
                                    name_of_type(object), dlpack_problem(object))
                            .c_str());
}

/// Reads the interface that numba and others have instead of DLPack, version 3: a dictionary.
bool read_cuda_interface(nb::handle object, Array& array) {
  if (!nb::hasattr(object, "__cuda_array_interface__")) return false;
  const nb::object interface = object.attr("__cuda_array_interface__");
  const auto type = nb::cast<std::string>(interface["typestr"]);
  if (type != "<f4" && type != "<f8") return false;
  const std::int64_t item_size = type == "<f4" ? sizeof(float) : sizeof(double);
  const auto shape = nb::cast<std::vector<std::size_t>>(interface["shape"]);
  std::vector<std::int64_t> strides(shape.size(), 1);
  for (std::size_t i = shape.size(); i-- > 1;) strides[i - 1] = strides[i] * static_cast<std::int64_t>(shape[i]);
  const nb::object given = interface.attr("get")("strides");
  if (!given.is_none()) {
    strides = nb::cast<std::vector<std::int64_t>>(given);
    for (std::int64_t& stride : strides) {
      if (stride % item_size != 0) return false;
      stride /= item_size;
    }
  }
  if (strides.size() != shape.size()) return false;
  const auto address = nb::cast<std::uintptr_t>(interface["data"][0]);
  array = Array(reinterpret_cast<const void*>(address), shape.size(), shape.data(), object, strides.data(),
                item_size == sizeof(float) ? nb::dtype<float>() : nb::dtype<double>(), nb::device::cuda::value, 0);
  return true;
}

bool is_on_cpu(const Array& array) {
  constexpr int kCpu = 1;
  constexpr int kPageLocked = 3;
  return array.device_type() == kCpu || array.device_type() == kPageLocked;
}

bool is_on_gpu(const Array& array) {
  constexpr int kCuda = 2;
  constexpr int kManaged = 13;
  return array.device_type() == kCuda || array.device_type() == kManaged;
}

std::string shape_of(const Array& array) {
  std::string shape;
  for (std::size_t i = 0; i < array.ndim(); ++i) shape += fmt::format("{}{}", i > 0 ? ", " : "", array.shape(i));
  return fmt::format("({}{})", shape, array.ndim() == 1 ? "," : "");
}

bool try_read(nb::handle object, bool may_be_on_gpu, Array& array) {
  return !object.is_none() &&
         (nb::try_cast(object, array, /*convert=*/false) || (may_be_on_gpu && read_cuda_interface(object, array)));
}

/// Reads a contiguous copy of an object that numpy reads as real numbers of at most 64 bits. The copy is float32 if
/// numpy has floats of at most 32 bits, else float64 or, with `integers`, int64. Returns whether the object could be
/// read.
bool try_read_copy(nb::handle object, bool integers, Array& array) {
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object given = numpy.attr("asarray")(object);
    const auto kind = nb::cast<std::string>(given.attr("dtype").attr("kind"));
    const auto size = nb::cast<std::size_t>(given.attr("dtype").attr("itemsize"));
    const bool is_integer = kind == "i" || kind == "u";
    if (nb::cast<int>(given.attr("ndim")) == 0 || size > 8 || !(is_integer || (kind == "f" && !integers))) return false;
    const char* const type =
        integers ? (kind == "u" ? "uint64" : "int64") : (!is_integer && size <= 4 ? "float32" : "float64");
    const nb::object copy = numpy.attr("require")(given, type, nb::make_tuple("C", "A"));
    return nb::try_cast(copy, array, /*convert=*/false);
  } catch (const nb::python_error& error) {
    if (error.matches(PyExc_MemoryError)) throw;
    return false;
  }
}

Array on_expected_device(const char* name, Array array, const char* expected, bool may_be_on_gpu) {
  if (!is_on_cpu(array) && !(may_be_on_gpu && is_on_gpu(array))) {
    throw nb::type_error(fmt::format("{}: expected {}, got one on device {} of DLPack's type {}; copy it to the CPU",
                                     name, expected, array.device_id(), array.device_type())
                             .c_str());
  }
  return array;
}

/// Throws InvalidInput unless there are rows of `width`, or one dimension if `width` is 0. `shape` describes this in
/// words.
void require_shape(const char* name, const Array& array, const char* shape, std::size_t width) {
  const bool fits = width == 0 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == width;
  if (!fits) throw InvalidInput(fmt::format("{}: expected shape {}, got {}", name, shape, shape_of(array)));
}

/// Returns the number of bytes from one row of the last two dimensions to the next.
std::size_t row_stride(const char* name, const Array& array, std::size_t item_size) {
  const std::size_t column = array.ndim() - 1;
  const std::size_t row = array.ndim() - 2;
  const auto width = static_cast<std::int64_t>(array.shape(column));
  if (array.size() > 0 && array.stride(column) != 1) {
    throw InvalidInput(
        fmt::format("{}: the coordinates of a position must lie side by side, but are {} apart; "
                    "numpy.ascontiguousarray makes a copy that can be read",
                    name, array.stride(column)));
  }
  if (array.shape(row) <= 1) return static_cast<std::size_t>(width) * item_size;
  if (array.stride(row) < width) {
    throw InvalidInput(
        fmt::format("{}: rows must follow each other, but begin {} elements apart; "
                    "numpy.ascontiguousarray makes a copy that can be read",
                    name, array.stride(row)));
  }
  return static_cast<std::size_t>(array.stride(row)) * item_size;
}

bool is_of_floats(const Array& array) {
  return array.dtype() == nb::dtype<float>() || array.dtype() == nb::dtype<double>();
}

/// Returns whether positions can be read in place: one aligned row behind the other.
bool lies_in_rows(const Array& array) {
  if (!is_of_floats(array)) return false;
  const std::size_t item_size = array.dtype().bits / 8;
  const std::size_t column = array.ndim() - 1;
  const std::size_t row = array.ndim() - 2;
  return reinterpret_cast<std::uintptr_t>(array.data()) % item_size == 0 &&
         (array.size() == 0 || array.stride(column) == 1) && (array.shape(row) <= 1 || array.stride(row) >= 3);
}

/// Returns the rows of the last two dimensions, from the element with this offset on.
template <class Scalar>
Positions positions_in(const char* name, const Array& array, std::int64_t offset = 0) {
  const auto* const first = static_cast<const Scalar*>(array.data()) + offset;
  if (reinterpret_cast<std::uintptr_t>(first) % alignof(Scalar) != 0) {
    throw InvalidInput(fmt::format("{}: its memory is not aligned; numpy.array makes a copy that is", name));
  }
  const std::size_t count = array.shape(array.ndim() - 2);
  const std::size_t stride = row_stride(name, array, sizeof(Scalar));
  return is_on_gpu(array) ? Positions::on_device(first, count, stride) : Positions(first, count, stride);
}

template <class Scalar>
std::vector<Positions> positions_of_copies_in(const char* name, const Array& array) {
  std::vector<Positions> of;
  of.reserve(array.shape(0));
  for (std::size_t copy = 0; copy < array.shape(0); ++copy) {
    of.push_back(positions_in<Scalar>(name, array, static_cast<std::int64_t>(copy) * array.stride(0)));
  }
  return of;
}

template <class Scalar>
void require_finite_scalars(const char* name, const Positions& positions, std::optional<std::uint32_t> environment) {
  const auto* row = static_cast<const char*>(positions.data());
  for (std::size_t i = 0; i < positions.count(); ++i, row += positions.stride()) {
    const auto* const x = reinterpret_cast<const Scalar*>(row);
    const auto is_usable = [](Scalar value) { return std::abs(value) <= static_cast<Scalar>(kLargestCoordinate); };
    if (is_usable(x[0]) && is_usable(x[1]) && is_usable(x[2])) continue;
    const std::string place = environment ? fmt::format("environment {}, ", *environment) : "";
    throw InvalidInput(
        fmt::format("{}: {}row {} is ({}, {}, {}), not finite or beyond 1e37", name, place, i, x[0], x[1], x[2]));
  }
}

template <class Row>
inline constexpr std::size_t kWidth = sizeof(Row) / sizeof(std::uint32_t);

/// Reads rows of kWidth<Row> indices each.
template <class Row, class Integer>
std::vector<Row> rows_in(const char* name, const Array& array) {
  const auto* const first = static_cast<const char*>(static_cast<const void*>(array.data()));
  const std::int64_t column_stride = array.ndim() > 1 ? array.stride(1) : 0;
  const auto at = [&](std::size_t row, std::size_t column) {
    Integer value;
    const std::int64_t offset =
        static_cast<std::int64_t>(row) * array.stride(0) + static_cast<std::int64_t>(column) * column_stride;
    std::memcpy(&value, first + offset * static_cast<std::int64_t>(sizeof(Integer)), sizeof(Integer));
    return value;
  };
  std::vector<Row> rows(array.shape(0));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    std::array<std::uint32_t, kWidth<Row>> indices{};
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const Integer index = at(row, i);
      if (std::cmp_less(index, 0) || std::cmp_greater_equal(index, kNoIndex)) {
        throw InvalidInput(fmt::format("{}: row {} has the index {}, which is out of range", name, row, index));
      }
      indices[i] = static_cast<std::uint32_t>(index);
    }
    rows[row] = std::bit_cast<Row>(indices);
  }
  return rows;
}

/// Reads rows with as many dimensions and columns as `shape` says in words.
template <class Row>
std::vector<Row> read_rows(const char* name, nb::handle object, const char* shape) {
  const std::string expected = fmt::format("an array of integers of shape {} in the CPU's memory", shape);
  Array array;
  if (!try_read(object, false, array) && !try_read_copy(object, /*integers=*/true, array)) {
    throw wrong_type(name, object, expected.c_str());
  }
  array = on_expected_device(name, std::move(array), expected.c_str(), false);
  require_shape(name, array, shape, std::is_same_v<Row, std::uint32_t> ? 0 : kWidth<Row>);
  const auto is_of = [&](auto integer) { return array.dtype() == nb::dtype<decltype(integer)>(); };
  if (is_of(std::uint32_t{})) return rows_in<Row, std::uint32_t>(name, array);
  if (is_of(std::int32_t{})) return rows_in<Row, std::int32_t>(name, array);
  if (is_of(std::int64_t{})) return rows_in<Row, std::int64_t>(name, array);
  if (is_of(std::uint64_t{})) return rows_in<Row, std::uint64_t>(name, array);
  if (is_of(std::int16_t{})) return rows_in<Row, std::int16_t>(name, array);
  if (is_of(std::uint16_t{})) return rows_in<Row, std::uint16_t>(name, array);
  throw nb::type_error(fmt::format("{}: expected {}, got {}", name, expected, dtype_name(array)).c_str());
}

/// Reads floats of a shape for which `has_shape(array)`, `shape` in words. `expected` describes the allowed memory.
template <class HasShape>
Array read_floats(const char* name, nb::handle object, const char* expected, bool may_be_on_gpu,
                  const std::string& shape, const HasShape& has_shape) {
  Array array;
  const bool is_read = try_read(object, may_be_on_gpu, array);
  const bool needs_copy = !is_read || (has_shape(array) && is_on_cpu(array) && !lies_in_rows(array));
  if (needs_copy && !try_read_copy(object, /*integers=*/false, array) && !is_read) {
    throw wrong_type(name, object, expected);
  }
  array = on_expected_device(name, std::move(array), expected, may_be_on_gpu);
  if (!has_shape(array)) {
    throw InvalidInput(fmt::format("{}: expected shape {}, got {}", name, shape, shape_of(array)));
  }
  if (!is_of_floats(array)) {
    throw nb::type_error(fmt::format("{}: expected {}, got {}", name, expected, dtype_name(array)).c_str());
  }
  return array;
}

PositionsArray read_rows_of_floats(const char* name, nb::handle object, const char* expected, bool may_be_on_gpu) {
  Array array = read_floats(name, object, expected, may_be_on_gpu, "(n, 3)",
                            [](const Array& read) { return read.ndim() == 2 && read.shape(1) == 3; });
  const bool is_float = array.dtype() == nb::dtype<float>();
  const Positions positions = is_float ? positions_in<float>(name, array) : positions_in<double>(name, array);
  return {std::move(array), positions};
}

template <class Scalar>
std::vector<Vec3d> points_of(const Positions& positions) {
  std::vector<Vec3d> points(positions.count());
  const auto* row = static_cast<const char*>(positions.data());
  for (Vec3d& point : points) {
    const auto* const x = reinterpret_cast<const Scalar*>(row);
    point = {double{x[0]}, double{x[1]}, double{x[2]}};
    row += positions.stride();
  }
  return points;
}

}  // namespace

PositionsArray read_positions(const char* name, nb::handle object) {
  return read_rows_of_floats(
      name, object, "an array of float32 or float64 of shape (n, 3) in the CPU's or a CUDA device's memory", true);
}

PositionsOfCopies read_positions_of_copies(const char* name, nb::handle object, std::uint32_t copies,
                                           std::uint32_t vertices) {
  const std::string shape = fmt::format("({}, {}, 3)", copies, vertices);
  const std::string expected =
      fmt::format("an array of float32 or float64 of shape {} in the CPU's or a CUDA device's memory", shape);
  Array array = read_floats(name, object, expected.c_str(), true, shape, [&](const Array& read) {
    return read.ndim() == 3 && read.shape(0) == copies && read.shape(1) == vertices && read.shape(2) == 3;
  });
  const bool is_float = array.dtype() == nb::dtype<float>();
  std::vector<Positions> of =
      is_float ? positions_of_copies_in<float>(name, array) : positions_of_copies_in<double>(name, array);
  return {std::move(array), std::move(of)};
}

std::vector<Vec3d> read_points(const char* name, nb::handle object) {
  const PositionsArray read =
      read_rows_of_floats(name, object, "an array of float32 or float64 of shape (n, 3) in the CPU's memory", false);
  return read.positions.is_double() ? points_of<double>(read.positions) : points_of<float>(read.positions);
}

void require_finite(const char* name, const Positions& positions, std::optional<std::uint32_t> environment) {
  if (positions.is_on_device()) return;
  if (positions.is_double()) {
    require_finite_scalars<double>(name, positions, environment);
  } else {
    require_finite_scalars<float>(name, positions, environment);
  }
}

std::vector<Triangle> read_triangles(const char* name, nb::handle object) {
  return read_rows<Triangle>(name, object, "(n, 3)");
}

std::vector<Segment> read_segments(const char* name, nb::handle object) {
  return read_rows<Segment>(name, object, "(n, 2)");
}

std::vector<std::uint32_t> read_indices(const char* name, nb::handle object) {
  return read_rows<std::uint32_t>(name, object, "(n,)");
}

}  // namespace softcd::python
