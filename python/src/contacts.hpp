#pragma once

#include <nanobind/nanobind.h>

#include "scene.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {

/// A Contact's members, as numpy describes them.
nb::handle contact_dtype();

/// A read-only structured array over the contacts, which `held` keeps.
nb::object contacts_array(Span<const Contact> contacts, HeldContacts held);

}  // namespace softcd::python
