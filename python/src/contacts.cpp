#include "contacts.hpp"

#include <nanobind/ndarray.h>

#include <cstddef>
#include <memory>

#include "bindings.hpp"

namespace softcd::python {
namespace {

/// A Contact's layout, as numpy describes it.
nb::object make_dtype() {
  nb::list names, formats, offsets;
  const auto add = [&](const char* name, nb::object format, std::size_t offset) {
    names.append(name);
    formats.append(std::move(format));
    offsets.append(offset);
  };
  const auto scalar = [](const char* format) { return nb::object(nb::str(format)); };
  const auto several = [](const char* format, int count) {
    return nb::object(nb::make_tuple(format, nb::make_tuple(count)));
  };
  add("kind", scalar("u1"), offsetof(Contact, kind));
  add("is_unsettled", scalar("?"), offsetof(Contact, is_unsettled));
  add("body_a", scalar("=u4"), offsetof(Contact, body_a));
  add("body_b", scalar("=u4"), offsetof(Contact, body_b));
  add("feature_a", scalar("=u4"), offsetof(Contact, feature_a));
  add("feature_b", scalar("=u4"), offsetof(Contact, feature_b));
  add("vertices", several("=u4", 4), offsetof(Contact, vertices));
  add("weights", several("=f4", 4), offsetof(Contact, weights));
  add("normal", several("=f4", 3), offsetof(Contact, normal));
  add("distance", scalar("=f4"), offsetof(Contact, distance));
  add("time_of_impact", scalar("=f4"), offsetof(Contact, time_of_impact));
  nb::dict layout;
  layout["names"] = names;
  layout["formats"] = formats;
  layout["offsets"] = offsets;
  layout["itemsize"] = sizeof(Contact);
  return nb::module_::import_("numpy").attr("dtype")(layout);
}

nb::handle contact_dtype() {
  static const nb::object* const dtype = new nb::object(make_dtype());  // never destroyed: numpy may be gone before
  return *dtype;
}

}  // namespace

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
