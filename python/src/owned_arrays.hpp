#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace softcd::python {

namespace nb = nanobind;

/// Returns a numpy array of rows of kWidth scalars that owns the rows.
template <class Scalar, std::size_t kWidth, class Row>
nb::object own(std::vector<Row> rows) {
  static_assert(sizeof(Row) == kWidth * sizeof(Scalar));
  auto kept = std::make_unique<std::vector<Row>>(std::move(rows));
  auto* const data = reinterpret_cast<Scalar*>(kept->data());
  const std::size_t count = kept->size();
  const nb::capsule keeper(kept.get(), [](void* owned) noexcept { delete static_cast<std::vector<Row>*>(owned); });
  static_cast<void>(kept.release());
  return nb::cast(nb::ndarray<nb::numpy, Scalar, nb::shape<-1, kWidth>>(data, {count, kWidth}, keeper));
}

/// Returns a structured numpy array that owns the structs.
template <class Struct>
nb::object own_structs(std::vector<Struct> structs, nb::handle dtype) {
  return own<std::uint8_t, sizeof(Struct)>(std::move(structs)).attr("view")(dtype).attr("reshape")(-1);
}

/// The layout of a struct in numpy's terms.
class StructLayout {
 public:
  /// Adds a member of one value. `format` is numpy's.
  void add(const char* name, const char* format, std::size_t offset) { add(name, nb::object(nb::str(format)), offset); }
  /// Adds a member of `count` values.
  void add(const char* name, const char* format, int count, std::size_t offset) {
    add(name, nb::object(nb::make_tuple(format, nb::make_tuple(count))), offset);
  }
  nb::object dtype(std::size_t size) const {
    nb::dict layout;
    layout["names"] = names_;
    layout["formats"] = formats_;
    layout["offsets"] = offsets_;
    layout["itemsize"] = size;
    return nb::module_::import_("numpy").attr("dtype")(layout);
  }

 private:
  void add(const char* name, nb::object format, std::size_t offset) {
    names_.append(name);
    formats_.append(std::move(format));
    offsets_.append(offset);
  }

  nb::list names_, formats_, offsets_;
};

}  // namespace softcd::python
