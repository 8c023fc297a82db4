#include "device_contacts.hpp"

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "collected.hpp"
#include "contacts.hpp"
#include "softcd/core/loaded_library.hpp"

namespace softcd::python {
namespace {

constexpr std::intptr_t kLegacyDefaultStream = 1;  // numbered as in CUDA and DLPack
constexpr std::intptr_t kNoStream = -1;            // DLPack's value for a consumer that synchronizes by itself

#if defined(_WIN32)
constexpr const char* kDriver = "nvcuda.dll";
#else
constexpr const char* kDriver = "libcuda.so.1";
#endif

/// Lets work that is enqueued on a stream from now on wait for the event. It uses the driver, whose events and streams
/// are those of CUDA's runtime. A module that is built without CUDA has nothing else, and the driver is loaded where
/// there are events.
void wait_on_stream(std::intptr_t stream, void* event) {
  using StreamWaitEvent = int(void* stream, void* event, unsigned int flags);
  static StreamWaitEvent* const stream_wait_event = [] {
    StreamWaitEvent* function = nullptr;
    LoadedLibrary(kDriver).find("cuStreamWaitEvent", function);
    return function;
  }();
  const int result = stream_wait_event == nullptr ? -1 : stream_wait_event(reinterpret_cast<void*>(stream), event, 0);
  if (result != 0) {
    throw BackendError(
        fmt::format("cuStreamWaitEvent failed with {}: stream {} cannot wait for contacts that a detection is still "
                    "looking for. Use Ticket.wait() instead.",
                    result, stream));
  }
}

nb::object keep(HeldContacts held) {
  auto owner = std::make_unique<HeldContacts>(std::move(held));
  nb::capsule keeper(owner.get(), [](void* kept) noexcept { delete static_cast<HeldContacts*>(kept); });
  static_cast<void>(owner.release());
  return keeper;
}

/// Returns one member of each of `count` contacts.
DeviceArray column_of(const Contact* contacts, std::size_t count, const std::string& name,
                      const DeviceArray::Origin& origin) {
  const nb::object fields = contact_dtype().attr("fields");
  if (!nb::cast<bool>(fields.attr("__contains__")(name))) {
    throw nb::key_error(fmt::format("{}: a contact's columns are those of softcd.contact_dtype", name).c_str());
  }
  const nb::object field = fields[name.c_str()];
  const nb::object type = field[0];
  const nb::object base = type.attr("base");
  const auto item_size = nb::cast<std::size_t>(base.attr("itemsize"));
  std::vector<std::size_t> shape = {count};
  std::vector<std::int64_t> strides = {static_cast<std::int64_t>(sizeof(Contact) / item_size)};
  for (const nb::handle extent : type.attr("shape")) {
    shape.push_back(nb::cast<std::size_t>(extent));
    strides.push_back(1);
  }
  const bool is_real = nb::cast<std::string>(base.attr("kind")) == "f";
  const nb::dlpack::dtype dtype = item_size == 1 ? nb::dtype<std::uint8_t>()
                                  : is_real      ? nb::dtype<float>()
                                                 : nb::dtype<std::int32_t>();
  const auto* const first = reinterpret_cast<const std::byte*>(contacts) + nb::cast<std::size_t>(field[1]);
  return {{first, shape, strides, dtype, nb::cast<std::string>(base.attr("str")), item_size}, origin};
}

/// Returns `count` integers, or none where there is no memory.
template <class Integer>
DeviceArray integers(const void* first, std::size_t count, const DeviceArray::Origin& origin) {
  constexpr const char* kType = sizeof(Integer) == sizeof(std::int64_t) ? "<i8" : "<i4";
  return {{first, {first != nullptr ? count : 0}, {1}, nb::dtype<Integer>(), kType, sizeof(Integer)}, origin};
}

DeviceArray body_begins(const std::uint64_t* begin, std::uint32_t body_ids, const DeviceArray::Origin& origin) {
  return integers<std::int64_t>(begin, 2 * std::size_t{body_ids} + 1, origin);
}

/// Returns, of the ranges in `begin`, those of each kind, body and environment: all their begins, or all their ends.
DeviceArray environment_ranges(const std::uint64_t* begin, std::uint32_t body_ids, bool are_ends,
                               const DeviceArray::Origin& origin) {
  const std::uint32_t bodies = begin != nullptr ? body_ids / origin.environments : 0;
  const std::vector<std::int64_t> strides = {body_ids, origin.environments, 1};
  const void* const first = begin != nullptr ? begin + (are_ends ? 1 : 0) : nullptr;
  return {{first, {2, bodies, origin.environments}, strides, nb::dtype<std::int64_t>(), "<i8", sizeof(std::int64_t)},
          origin};
}

}  // namespace

nb::object DeviceArray::dlpack(const nb::kwargs& arguments) const {
  nb::dict others;
  std::intptr_t stream = kLegacyDefaultStream;
  for (const auto& [name, value] : arguments) {
    if (nb::cast<std::string>(name) != "stream") {
      others[name] = value;
    } else if (!value.is_none()) {
      stream = nb::cast<std::intptr_t>(value);
    }
  }
  if (origin_.ready != nullptr && stream != kNoStream) wait_on_stream(stream, origin_.ready);
  const nb::object array = nb::cast(nb::ndarray<nb::array_api>(
      const_cast<void*>(layout_.first), layout_.shape.size(), layout_.shape.data(), origin_.memory,
      layout_.strides.data(), layout_.dtype, nb::device::cuda::value, origin_.device));
  return array.attr("__dlpack__")(**others);
}

nb::tuple DeviceArray::dlpack_device() const {
  return nb::make_tuple(int{nb::device::cuda::value}, origin_.device);
}

/// Version 3: the reader waits for the stream that the dictionary names.
nb::dict DeviceArray::cuda_array_interface() const {
  nb::list strides;
  for (const std::int64_t stride : layout_.strides)
    strides.append(stride * static_cast<std::int64_t>(layout_.item_size));
  nb::dict interface;
  interface["shape"] = shape();
  interface["typestr"] = layout_.numpy_type;
  interface["data"] = nb::make_tuple(reinterpret_cast<std::uintptr_t>(layout_.first), false);
  interface["version"] = 3;
  interface["strides"] = nb::tuple(strides);
  if (origin_.ready == nullptr) {
    interface["stream"] = nb::none();
  } else {
    wait_on_stream(kLegacyDefaultStream, origin_.ready);
    interface["stream"] = kLegacyDefaultStream;
  }
  return interface;
}

nb::tuple DeviceArray::shape() const {
  nb::list shape;
  for (const std::size_t extent : layout_.shape) shape.append(extent);
  return nb::tuple(shape);
}

std::string DeviceArray::describe() const {
  return fmt::format("<softcd.DeviceArray of shape {} on CUDA device {}>", nb::cast<std::string>(nb::str(shape())),
                     origin_.device);
}

int DeviceArray::traverse(visitproc visit, void* arg) const {
  Py_VISIT(origin_.query.ptr());
  return 0;
}

DeviceContactsArray::DeviceContactsArray(const DeviceContacts& contacts, HeldContacts held, std::uint32_t environments)
    : contacts_(contacts), origin_{keep(std::move(held)), {}, nullptr, contacts.device, environments} {}

DeviceArray DeviceContactsArray::column(const std::string& name) const {
  return column_of(contacts_.data, contacts_.count, name, origin_);
}
DeviceArray DeviceContactsArray::body_begin() const {
  return body_begins(contacts_.body_begin, contacts_.body_ids, origin_);
}
DeviceArray DeviceContactsArray::environment_begin() const {
  return environment_ranges(contacts_.body_begin, contacts_.body_ids, false, origin_);
}
DeviceArray DeviceContactsArray::environment_end() const {
  return environment_ranges(contacts_.body_begin, contacts_.body_ids, true, origin_);
}

PendingContactsArray::PendingContactsArray(const PendingContacts& contacts, HeldContacts held, nb::object query,
                                           std::uint32_t environments)
    : contacts_(contacts),
      origin_{keep(std::move(held)), std::move(query), contacts.ready, contacts.device, environments} {}

DeviceArray PendingContactsArray::column(const std::string& name) const {
  return column_of(contacts_.data, capacity(), name, origin_);
}
DeviceArray PendingContactsArray::body_begin() const {
  return body_begins(contacts_.body_begin, contacts_.body_ids, origin_);
}
DeviceArray PendingContactsArray::environment_begin() const {
  return environment_ranges(contacts_.body_begin, contacts_.body_ids, false, origin_);
}
DeviceArray PendingContactsArray::environment_end() const {
  return environment_ranges(contacts_.body_begin, contacts_.body_ids, true, origin_);
}
DeviceArray PendingContactsArray::count() const {
  return integers<std::int64_t>(contacts_.counts, 1, origin_);
}
DeviceArray PendingContactsArray::is_complete() const {
  const auto* const counts = reinterpret_cast<const std::byte*>(contacts_.counts);
  return integers<std::int32_t>(counts != nullptr ? counts + offsetof(ContactCounts, is_complete) : nullptr, 1,
                                origin_);
}
int PendingContactsArray::traverse(visitproc visit, void* arg) const {
  Py_VISIT(origin_.query.ptr());
  return 0;
}

namespace {

constexpr const char* kBodyBegin =
    "The range of each body's contacts, on the GPU: int64 of shape (2 * n + 1,), where n exceeds all bodies' ids. "
    "Contacts of kind k whose body_a is b are [body_begin[k * n + b], body_begin[k * n + b + 1]). Of shape (0,) where "
    "no bodies were compared.";
constexpr const char* kEnvironmentBegin =
    "Where the contacts of each environment begin, on the GPU: int64 of shape (2, bodies, environments), a view of "
    "body_begin. Contacts of environment e are, for each kind k and body b, [environment_begin[k, b, e], "
    "environment_end[k, b, e]): those of kind k whose body_a is body b of e. A Query has one environment.";
constexpr const char* kEnvironmentEnd = "Where the contacts that environment_begin describes end, of the same shape.";

PyType_Slot array_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<DeviceArray>)}, {0, nullptr}};
PyType_Slot pending_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<PendingContactsArray>)},
                               {0, nullptr}};

}  // namespace

void bind_device_contacts(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<DeviceArray>(
      module, "DeviceArray", nb::type_slots(array_slots),
      "An array in a GPU's memory. torch.from_dlpack, cupy.from_dlpack, numba and similar functions read it in place. "
      "With __dlpack__ unsigned integers are int32 and truth values uint8.")
      .def("__dlpack__", &DeviceArray::dlpack, "kwargs"_a,
           "Makes the given stream, or DLPack's legacy default stream, wait until the array is complete.")
      .def("__dlpack_device__", &DeviceArray::dlpack_device)
      .def_prop_ro("__cuda_array_interface__", &DeviceArray::cuda_array_interface)
      .def_prop_ro("shape", &DeviceArray::shape)
      .def("__repr__", &DeviceArray::describe);
  nb::class_<DeviceContactsArray>(
      module, "DeviceContacts",
      "Contacts in a GPU's memory, with columns that are not copied. They do not change, whatever happens to the "
      "query: other detections use other memory as long as they, or a column of them, live.")
      .def("__len__", &DeviceContactsArray::size)
      .def("__getitem__", &DeviceContactsArray::column, "name"_a, "A column of softcd.contact_dtype.")
      .def_prop_ro("body_begin", &DeviceContactsArray::body_begin, kBodyBegin)
      .def_prop_ro("environment_begin", &DeviceContactsArray::environment_begin, kEnvironmentBegin)
      .def_prop_ro("environment_end", &DeviceContactsArray::environment_end, kEnvironmentEnd)
      .def("__repr__", [](const DeviceContactsArray& self) {
        return fmt::format("<softcd.DeviceContacts, {} on CUDA device {}>", self.size(), self.device());
      });
  nb::class_<PendingContactsArray>(
      module, "PendingContacts", nb::type_slots(pending_slots),
      "Contacts in a GPU's memory, of a detection that may still run. A stream that takes an array waits for them; the "
      "host does not. Their number, and whether they are complete, are known on the GPU: contacts behind count[0] are "
      "useless, and all are where is_complete[0] is 0. Ticket.wait() then repeats the detection, after which these "
      "arrays must not be read.")
      .def_prop_ro("capacity", &PendingContactsArray::capacity, "The number of contacts that fit.")
      .def("__getitem__", &PendingContactsArray::column, "name"_a, "A column of softcd.contact_dtype, `capacity` long.")
      .def_prop_ro(
          "count", &PendingContactsArray::count,
          "On the GPU: the number of contacts found, int64 of shape (1,), or (0,) where no bodies are compared.")
      .def_prop_ro(
          "is_complete", &PendingContactsArray::is_complete,
          "On the GPU: 1 where all contacts are stored, int32 of shape (1,), or (0,) where no bodies are compared.")
      .def_prop_ro("body_begin", &PendingContactsArray::body_begin, kBodyBegin)
      .def_prop_ro("environment_begin", &PendingContactsArray::environment_begin, kEnvironmentBegin)
      .def_prop_ro("environment_end", &PendingContactsArray::environment_end, kEnvironmentEnd)
      .def_prop_ro("ready", &PendingContactsArray::ready,
                   "A cudaEvent_t after which all results are there, for cupy.cuda.runtime.streamWaitEvent and similar "
                   "functions, until the query's next detection is started.")
      .def("__repr__", [](const PendingContactsArray& self) {
        return fmt::format("<softcd.PendingContacts, capacity {}, on CUDA device {}>", self.capacity(), self.device());
      });
}

}  // namespace softcd::python
