#include <nanobind/nanobind.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <utility>

#include "bindings.hpp"
#include "collected.hpp"
#include "contacts.hpp"
#include "device_contacts.hpp"
#include "fields.hpp"
#include "keywords.hpp"
#include "scene.hpp"

namespace softcd::python {
namespace {

struct Found {
  Span<const Contact> contacts;
  std::optional<DeviceContacts> on_device;  ///< instead
  std::shared_ptr<const void> memory;
};

/// softcd::Query for Python, which keeps its scene alive.
class BoundQuery {
 public:
  BoundQuery(nb::object scene, const QueryOptions& options)
      : object_(std::move(scene)), scene_(nb::cast<BoundScene&>(object_)) {
    scene_.call([&](Scene& bound) {
      auto query = std::make_shared<Query>(bound, options);
      query_ = query.get();
      discardable_.push_back(std::move(query));
    });
  }
  BoundQuery(const BoundQuery&) = delete;
  BoundQuery& operator=(const BoundQuery&) = delete;
  ~BoundQuery() { scene_.discarded()->add(discardable_); }

  Ticket start(Pairs pairs) {
    return scene_.call_and_read(nb::find(this), [this, pairs](Scene&) { return query_->start(pairs); });
  }
  /// Waits for the detection. `owner` is the ticket's Python object.
  nb::object wait(nb::handle owner, Ticket& ticket) {
    return to_array(scene_.call_at_length(owner, [this, &ticket](Scene&) { return wait_and_hold(ticket); }));
  }
  nb::object detect(nb::handle pairs_asked) {
    const auto pairs = read_enumerator<Pairs>("pairs", pairs_asked);
    return to_array(scene_.call_and_read(nb::find(this), [this, pairs](Scene&) {
      Ticket ticket = query_->start(pairs);
      return wait_and_hold(ticket);
    }));
  }

  /// Returns the pending contacts. `query` is this object's Python object.
  PendingContactsArray on_device(Ticket& ticket, nb::object query) {
    PendingContacts found;
    std::shared_ptr<const void> memory;
    scene_.call([&](Scene&) {
      found = ticket.on_device();
      if (found.counts != nullptr) memory = query_->hold_contacts();
    });
    return {found, HeldContacts(std::move(memory), scene_.discarded()), std::move(query)};
  }

  QueryOptions options() {
    return scene_.call([&](Scene&) { return query_->options(); });
  }
  void set_options(const QueryOptions& options) {
    scene_.call([&](Scene&) { query_->set_options(options); });
  }
  void set_pair_filter(nb::object filter) {
    PairFilter asked;
    if (!filter.is_none()) asked = [this](BodyId a, BodyId b) { return ask(a, b); };
    scene_.call([&](Scene&) {
      query_->set_pair_filter(std::move(asked));
      std::swap(filter_, filter);
    });
  }
  void set_only_pairs(const NumberPairs& pairs) {
    const std::vector<BodyPair> only = body_pairs(pairs);
    scene_.call([&](Scene&) { query_->set_only_pairs(only); });
  }
  Statistics statistics() {
    return scene_.call([&](Scene&) { return query_->statistics(); });
  }
  std::vector<StageReport> explain() {
    return scene_.call([&](Scene&) { return query_->explain(); });
  }

  int traverse(visitproc visit, void* arg) {
    Py_VISIT(object_.ptr());
    Py_VISIT(filter_.ptr());
    return 0;
  }
  /// Breaks cycles, which lead through the filter.
  void clear() { filter_.reset(); }

 private:
  Found wait_and_hold(Ticket& ticket) {
    Found found;
    if (query_->options().contacts_on_device) {
      found.on_device = ticket.wait_on_device();
    } else {
      found.contacts = ticket.wait();
    }
    found.memory = query_->hold_contacts();
    return found;
  }
  nb::object to_array(const Found& found) {
    HeldContacts held(found.memory, scene_.discarded());
    if (found.on_device) return nb::cast(DeviceContactsArray(*found.on_device, std::move(held)));
    return contacts_array(found.contacts, std::move(held));
  }
  bool ask(BodyId a, BodyId b) {
    const nb::gil_scoped_acquire interpreter;
    if (!filter_.is_valid()) return true;
    return nb::cast<bool>(nb::bool_(filter_(a.value, b.value)));
  }

  nb::object object_;
  BoundScene& scene_;
  Discardable discardable_;  ///< the query
  Query* query_ = nullptr;
  nb::object filter_;
};

/// softcd::Ticket for Python, which keeps its query alive.
class BoundTicket {
 public:
  BoundTicket(nb::object query, Pairs pairs)
      : object_(std::move(query)), query_(nb::cast<BoundQuery&>(object_)), ticket_(query_.start(pairs)) {}

  nb::object wait() { return query_.wait(nb::find(this), ticket_); }
  PendingContactsArray on_device() { return query_.on_device(ticket_, object_); }
  int traverse(visitproc visit, void* arg) {
    Py_VISIT(object_.ptr());
    return 0;
  }

 private:
  nb::object object_;
  BoundQuery& query_;
  Ticket ticket_;
};

PyType_Slot query_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<BoundQuery>)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_object<BoundQuery>)},
                             {0, nullptr}};
PyType_Slot ticket_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<BoundTicket>)}, {0, nullptr}};

constexpr const char* kDetect =
    "Reads the positions that were set, finds all contacts and returns them as a read-only structured array "
    "(softcd.contact_dtype) over the library's memory, each once, sorted by (kind, body_a, feature_a, body_b, "
    "feature_b). It does not change, whatever happens to the query: other detections use other memory as long as it "
    "lives. With contacts_on_device the result is DeviceContacts instead.";

}  // namespace

void bind_query(nb::module_& module) {
  using namespace nb::literals;
  auto options = nb::class_<QueryOptions>(module, "QueryOptions", "The options of a query.");
  Fields<QueryOptions>().define_value(options);

  nb::class_<BoundTicket>(module, "Ticket", nb::type_slots(ticket_slots), "A detection that was started.")
      .def("wait", &BoundTicket::wait, nb::sig("def wait(self) -> numpy.typing.NDArray[numpy.void] | DeviceContacts"),
           "Waits for the detection and returns what Query.detect returns. Raises the error of a detection that "
           "failed. Raises Error when it was called before, when the query has started another detection, or when "
           "options were set.")
      .def("on_device", &BoundTicket::on_device,
           "Returns the PendingContacts of a query with contacts_on_device, without waiting for them. Raises the "
           "errors of wait().");

  auto query = nb::class_<BoundQuery>(module, "Query", nb::type_slots(query_slots),
                                      "Finds contacts between the bodies of a scene. The same input gives the same "
                                      "bytes, on any backend, with any number of threads.");
  Fields<QueryOptions>().define<BoundQuery*, nb::handle_t<BoundScene>>(
      query, "__init__", "scene: Scene, *", "None",
      [](BoundQuery* self, nb::handle scene, const QueryOptions& values) {
        new (self) BoundQuery(nb::borrow(scene), values);
      },
      "scene"_a);
  query
      .def("detect", &BoundQuery::detect, "pairs"_a = Pairs::all,
           nb::sig("def detect(self, pairs: Pairs | str = ...) -> numpy.typing.NDArray[numpy.void] | DeviceContacts"),
           kDetect)
      .def(
          "start",
          [](nb::object self, nb::handle pairs) {
            return new BoundTicket(std::move(self), read_enumerator<Pairs>("pairs", pairs));
          },
          "pairs"_a = Pairs::all, nb::sig("def start(self, pairs: Pairs | str = ...) -> Ticket"),
          "Reads the positions that were set, and starts a detection. The next step's positions may be set while it "
          "runs.")
      .def("set_pair_filter", &BoundQuery::set_pair_filter, "filter"_a.none(),
           "Sets the function filter(a, b) that every later detection asks whether bodies a <= b are compared; None "
           "admits all pairs. It must not call the scene or its queries.")
      .def("set_only_pairs", &BoundQuery::set_only_pairs, "pairs"_a,
           "Restricts later detections to these pairs of bodies; an empty list restricts nothing.")
      .def_prop_rw("options", &BoundQuery::options, &BoundQuery::set_options,
                   "The options. Setting them ends a running detection of the query.")
      .def_prop_ro("statistics", &BoundQuery::statistics, "The statistics of the last detection that was waited for.")
      .def("explain", &BoundQuery::explain, "Returns which stages that detection ran or skipped, and why.")
      .def("__repr__", [](BoundQuery& self) {
        return "<softcd.Query " + nb::cast<std::string>(nb::repr(nb::cast(self.options()))) + ">";
      });
}

}  // namespace softcd::python
