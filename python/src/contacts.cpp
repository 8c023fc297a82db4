#include "contacts.hpp"

#include <nanobind/ndarray.h>

#include <cstddef>
#include <memory>
#include <utility>

#include "bindings.hpp"
#include "owned_arrays.hpp"

namespace softcd::python {
namespace {

nb::object make_dtype() {
  StructLayout layout;
  layout.add("kind", "u1", offsetof(Contact, kind));
  layout.add("is_unsettled", "?", offsetof(Contact, is_unsettled));
  layout.add("body_a", "=u4", offsetof(Contact, body_a));
  layout.add("body_b", "=u4", offsetof(Contact, body_b));
  layout.add("feature_a", "=u4", offsetof(Contact, feature_a));
  layout.add("feature_b", "=u4", offsetof(Contact, feature_b));
  layout.add("vertices", "=u4", 4, offsetof(Contact, vertices));
  layout.add("weights", "=f4", 4, offsetof(Contact, weights));
  layout.add("normal", "=f4", 3, offsetof(Contact, normal));
  layout.add("distance", "=f4", offsetof(Contact, distance));
  layout.add("time_of_impact", "=f4", offsetof(Contact, time_of_impact));
  return layout.dtype(sizeof(Contact));
}

}  // namespace

nb::handle contact_dtype() {
  // Never destroyed, as numpy may be unloaded earlier.
  static const nb::object* const dtype = new nb::object(make_dtype());
  return *dtype;
}

nb::object contacts_array(Span<const Contact> contacts, HeldContacts held) {
  static const std::uint8_t nothing = 0;
  auto owner = std::make_unique<HeldContacts>(std::move(held));
  const nb::capsule keeper(owner.get(), [](void* kept) noexcept { delete static_cast<HeldContacts*>(kept); });
  static_cast<void>(owner.release());
  const auto* const bytes = contacts.empty() ? &nothing : reinterpret_cast<const std::uint8_t*>(contacts.data());
  const nb::ndarray<nb::numpy, const std::uint8_t, nb::ndim<1>> memory(bytes, {contacts.size() * sizeof(Contact)},
                                                                       keeper);
  return nb::cast(memory).attr("view")(contact_dtype());
}

void bind_contacts(nb::module_& module) {
  module.def(
      "contact_dtype", [] { return nb::borrow(contact_dtype()); },
      nb::sig("def contact_dtype() -> numpy.dtype[numpy.void]"));
}

}  // namespace softcd::python
