#pragma once

#include <nanobind/nanobind.h>

#include "scene.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {

/// A read-only structured array over the contacts, which `held` keeps.
nb::object contacts_array(Span<const Contact> contacts, HeldContacts held);

/// Contacts on a GPU, as columns.
class DeviceContactsArray {
 public:
  DeviceContactsArray(const DeviceContacts& contacts, HeldContacts held);

  std::size_t size() const { return contacts_.count; }
  int device() const { return contacts_.device; }
  nb::object column(const std::string& name) const;
  nb::object body_begin() const;

 private:
  DeviceContacts contacts_;
  nb::capsule keeper_;
};

}  // namespace softcd::python
