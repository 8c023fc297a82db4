#include "contacts.hpp"

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

DeviceContactsArray::DeviceContactsArray(const DeviceContacts& contacts, HeldContacts held) : contacts_(contacts) {
  auto owner = std::make_unique<HeldContacts>(std::move(held));
  keeper_ = nb::capsule(owner.get(), [](void* kept) noexcept { delete static_cast<HeldContacts*>(kept); });
  static_cast<void>(owner.release());
}

nb::object DeviceContactsArray::column(const std::string& name) const {
  const nb::object fields = contact_dtype().attr("fields");
  if (!nb::cast<bool>(fields.attr("__contains__")(name))) {
    throw nb::key_error(fmt::format("{}: a contact's columns are those of softcd.contact_dtype", name).c_str());
  }
  const nb::object field = fields[name.c_str()];
  const nb::object type = field[0];
  const nb::object base = type.attr("base");
  const auto item_size = nb::cast<std::size_t>(base.attr("itemsize"));
  std::vector<std::size_t> shape = {contacts_.count};
  std::vector<std::int64_t> strides = {static_cast<std::int64_t>(sizeof(Contact) / item_size)};
  for (const nb::handle extent : type.attr("shape")) {
    shape.push_back(nb::cast<std::size_t>(extent));
    strides.push_back(1);
  }
  const bool is_real = nb::cast<std::string>(base.attr("kind")) == "f";
  const nb::dlpack::dtype dtype = item_size == 1 ? nb::dtype<std::uint8_t>()
                                  : is_real      ? nb::dtype<float>()
                                                 : nb::dtype<std::int32_t>();
  const auto* const first = reinterpret_cast<const std::byte*>(contacts_.data) + nb::cast<std::size_t>(field[1]);
  return nb::cast(nb::ndarray<nb::array_api>(const_cast<std::byte*>(first), shape.size(), shape.data(), keeper_,
                                             strides.data(), dtype, nb::device::cuda::value, contacts_.device));
}

nb::object DeviceContactsArray::body_begin() const {
  const bool is_empty = contacts_.body_begin == nullptr;
  const std::size_t shape[] = {is_empty ? 0 : 2 * std::size_t{contacts_.body_ids} + 1};
  return nb::cast(nb::ndarray<nb::array_api>(const_cast<std::uint64_t*>(contacts_.body_begin), 1, shape, keeper_,
                                             nullptr, nb::dtype<std::int64_t>(), nb::device::cuda::value,
                                             contacts_.device));
}

void bind_contacts(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<DeviceContactsArray>(module, "DeviceContacts",
                                  "Contacts in a GPU's memory, whose columns are shown without a copy. They stay as "
                                  "they are, whatever becomes of the "
                                  "query; detections use other memory as long as they, or a column, live.")
      .def("__len__", &DeviceContactsArray::size)
      .def("__getitem__", &DeviceContactsArray::column, "name"_a,
           "A column of softcd.contact_dtype as an object with __dlpack__, for torch.from_dlpack, cupy.from_dlpack and "
           "the like: int32 for the dtype's uint32, uint8 for its bool.")
      .def_prop_ro(
          "body_begin", &DeviceContactsArray::body_begin,
          "Where each body's contacts are, on the GPU, an object with __dlpack__: int64 of shape (2 * n + 1,), n "
          "being more than all bodies' ids. Those of kind k whose body_a is b are [body_begin[k * n + b], "
          "body_begin[k * n + b + 1]). Of shape (0,) where no bodies were compared.")
      .def("__repr__", [](const DeviceContactsArray& self) {
        return fmt::format("<softcd.DeviceContacts, {} on CUDA device {}>", self.size(), self.device());
      });
  module.def(
      "contact_dtype", [] { return nb::borrow(contact_dtype()); },
      nb::sig("def contact_dtype() -> numpy.dtype[numpy.void]"));
}

}  // namespace softcd::python
