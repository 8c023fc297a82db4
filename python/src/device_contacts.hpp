#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <string>
#include <vector>

#include "scene.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {

/// An array in a GPU's memory, which Python's libraries read in place, by `__dlpack__` and `__cuda_array_interface__`.
/// A reader that takes it before it is complete waits, on the GPU.
class DeviceArray {
 public:
  struct Layout {
    const void* first;
    std::vector<std::size_t> shape;
    std::vector<std::int64_t> strides;  ///< in elements
    nb::dlpack::dtype dtype;            ///< one that all libraries know
    std::string numpy_type;             ///< of the elements as they are
    std::size_t item_size;              ///< in bytes
  };
  /// Data of both kinds of contacts on a GPU.
  struct Origin {
    nb::object memory;      ///< keeps it
    nb::object query;       ///< keeps `ready`, where there is one
    void* ready = nullptr;  ///< a cudaEvent_t, or null: all is there
    std::int32_t device = 0;
    std::uint32_t environments = 1;  ///< body b of environment e has the id b * environments + e
  };
  DeviceArray(Layout layout, const Origin& origin) : layout_(std::move(layout)), origin_(origin) {}

  nb::object dlpack(const nb::kwargs& arguments) const;
  nb::tuple dlpack_device() const;
  nb::dict cuda_array_interface() const;
  nb::tuple shape() const;
  std::string describe() const;
  int traverse(visitproc visit, void* arg) const;

 private:
  Layout layout_;
  Origin origin_;
};

/// Contacts on a GPU, as columns, of a finished detection.
class DeviceContactsArray {
 public:
  DeviceContactsArray(const DeviceContacts& contacts, HeldContacts held, std::uint32_t environments);

  std::size_t size() const { return contacts_.count; }
  int device() const { return contacts_.device; }
  DeviceArray column(const std::string& name) const;
  DeviceArray body_begin() const;
  DeviceArray environment_begin() const;
  DeviceArray environment_end() const;

 private:
  DeviceContacts contacts_;
  DeviceArray::Origin origin_;
};

/// Contacts on a GPU, as columns, of a detection that may still run.
class PendingContactsArray {
 public:
  /// `query` keeps the event that marks the contacts as complete.
  PendingContactsArray(const PendingContacts& contacts, HeldContacts held, nb::object query,
                       std::uint32_t environments);

  std::size_t capacity() const { return contacts_.counts != nullptr ? contacts_.capacity : 0; }
  int device() const { return contacts_.device; }
  std::uintptr_t ready() const { return reinterpret_cast<std::uintptr_t>(contacts_.ready); }
  DeviceArray column(const std::string& name) const;
  DeviceArray body_begin() const;
  DeviceArray environment_begin() const;
  DeviceArray environment_end() const;
  DeviceArray count() const;
  DeviceArray is_complete() const;
  int traverse(visitproc visit, void* arg) const;

 private:
  PendingContacts contacts_;
  DeviceArray::Origin origin_;
};

}  // namespace softcd::python
