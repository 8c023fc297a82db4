#include <nanobind/nanobind.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "batch_scene.hpp"
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
  std::optional<ContactsOfEnvironments> split;  ///< instead
};

/// softcd::Query for Python, which keeps its scene alive.
class BoundQuery {
 public:
  BoundQuery(nb::object scene, const QueryOptions& options)
      : BoundQuery(nb::cast<BoundScene&>(scene), scene, options) {}
  BoundQuery(BoundScene& scene, nb::object object, const QueryOptions& options)
      : object_(std::move(object)), scene_(scene) {
    scene_.call([&](Scene& bound) {
      auto query = std::make_shared<Query>(bound, options);
      query_ = query.get();
      discardable_.push_back(std::move(query));
    });
  }
  BoundQuery(const BoundQuery&) = delete;
  BoundQuery& operator=(const BoundQuery&) = delete;
  virtual ~BoundQuery() { scene_.discarded()->add(discardable_); }

  Ticket start(Pairs pairs) {
    return scene_.call_and_read(nb::find(this), [this, pairs](Scene&) { return query_->start(pairs); });
  }
  /// Waits for the detection. `owner` is the ticket's Python object.
  nb::object wait(nb::handle owner, Ticket& ticket) {
    return to_array(
        scene_.call_at_length(owner, [this, &ticket](Scene& scene) { return wait_and_hold(scene, ticket); }));
  }
  nb::object detect(nb::handle pairs_asked) {
    const auto pairs = read_enumerator<Pairs>("pairs", pairs_asked);
    return to_array(scene_.call_and_read(nb::find(this), [this, pairs](Scene& scene) {
      Ticket ticket = query_->start(pairs);
      return wait_and_hold(scene, ticket);
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
    return {found, HeldContacts(std::move(memory), scene_.discarded()), std::move(query), environments()};
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

 protected:
  bool is_on_device() const { return query_->options().contacts_on_device; }
  /// The number of environments that the scene's bodies are copies for.
  virtual std::uint32_t environments() const { return 1; }
  /// Waits for the detection. Called within call().
  virtual Found wait_and_hold(Scene& /*scene*/, Ticket& ticket) {
    Found found;
    if (is_on_device()) {
      found.on_device = ticket.wait_on_device();
    } else {
      found.contacts = ticket.wait();
    }
    found.memory = query_->hold_contacts();
    return found;
  }

 private:
  nb::object to_array(Found found) {
    if (found.split) return contacts_of_environments(std::move(*found.split));
    HeldContacts held(found.memory, scene_.discarded());
    if (found.on_device) return nb::cast(DeviceContactsArray(*found.on_device, std::move(held), environments()));
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

/// A query on a BatchScene, whose contacts are split into those of each environment.
class BoundBatchQuery : public BoundQuery {
 public:
  BoundBatchQuery(nb::object scene, const QueryOptions& options)
      : BoundQuery(nb::cast<BoundBatchScene&>(scene), scene, options), batch_(nb::cast<BoundBatchScene&>(scene)) {}

 private:
  Found wait_and_hold(Scene& scene, Ticket& ticket) override {
    if (is_on_device()) return BoundQuery::wait_and_hold(scene, ticket);
    Found found;
    found.split = batch_.split(ticket.wait(), scene.options().max_threads);
    return found;
  }

  std::uint32_t environments() const override { return batch_.environments(); }

  BoundBatchScene& batch_;
};

/// softcd::Ticket for Python, which keeps its query alive.
template <class OwnQuery>
class BoundTicket {
 public:
  BoundTicket(nb::object query, Pairs pairs)
      : object_(std::move(query)), query_(nb::cast<OwnQuery&>(object_)), ticket_(query_.start(pairs)) {}

  nb::object wait() { return query_.wait(nb::find(this), ticket_); }
  PendingContactsArray on_device() { return query_.on_device(ticket_, object_); }
  int traverse(visitproc visit, void* arg) {
    Py_VISIT(object_.ptr());
    return 0;
  }

 private:
  nb::object object_;
  OwnQuery& query_;
  Ticket ticket_;
};

template <class OwnQuery>
PyType_Slot query_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<OwnQuery>)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_object<OwnQuery>)},
                             {0, nullptr}};
template <class OwnQuery>
PyType_Slot ticket_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<BoundTicket<OwnQuery>>)},
                              {0, nullptr}};

/// The words in which the two kinds of queries differ.
struct QueryWords {
  const char* name;
  const char* ticket;
  const char* scene;  ///< the constructor's parameters
  /// The type of a detection's result. `Any` stands for DeviceContacts: checkers then accept what either of them has.
  std::string result;
  const char* description;
  const char* detect;
};

template <class OwnQuery, class OwnScene>
nb::class_<OwnQuery> bind_query_on(nb::module_& module, const QueryWords& words) {
  using namespace nb::literals;
  using OwnTicket = BoundTicket<OwnQuery>;
  const std::string wait = "def wait(self) -> " + words.result;
  nb::class_<OwnTicket>(module, words.ticket, nb::type_slots(ticket_slots<OwnQuery>), "A detection that was started.")
      .def("wait", &OwnTicket::wait, nb::sig(wait.c_str()),
           "Waits for the detection and returns what detect() returns. Raises the error of a detection that failed. "
           "Raises Error when it was called before, when the query has started another detection, or when options were "
           "set.")
      .def("on_device", &OwnTicket::on_device,
           "Returns the PendingContacts of a query with contacts_on_device, without waiting for them. Raises the "
           "errors of wait().");

  nb::class_<OwnQuery> query(module, words.name, nb::type_slots(query_slots<OwnQuery>), words.description);
  Fields<QueryOptions>().define<OwnQuery*, nb::handle_t<OwnScene>>(
      query, "__init__", words.scene, "None",
      [](OwnQuery* self, nb::handle scene, const QueryOptions& values) {
        new (self) OwnQuery(nb::borrow(scene), values);
      },
      "scene"_a);
  const std::string detect = "def detect(self, pairs: Pairs | str = ...) -> " + words.result;
  const std::string start = std::string("def start(self, pairs: Pairs | str = ...) -> ") + words.ticket;
  query
      .def(
          "detect", [](OwnQuery& self, nb::handle pairs) { return self.detect(pairs); }, "pairs"_a = Pairs::all,
          nb::sig(detect.c_str()), words.detect)
      .def(
          "start",
          [](nb::object self, nb::handle pairs) {
            return new OwnTicket(std::move(self), read_enumerator<Pairs>("pairs", pairs));
          },
          "pairs"_a = Pairs::all, nb::sig(start.c_str()),
          "Reads the positions that were set, and starts a detection. The next step's positions may be set while it "
          "runs.")
      .def_prop_rw(
          "options", [](OwnQuery& self) { return self.options(); },
          [](OwnQuery& self, const QueryOptions& options) { self.set_options(options); },
          "The options. Setting them ends a running detection of the query.")
      .def_prop_ro(
          "statistics", [](OwnQuery& self) { return self.statistics(); },
          "The statistics of the last detection that was waited for.")
      .def(
          "explain", [](OwnQuery& self) { return self.explain(); },
          "Returns which stages that detection ran or skipped, and why.")
      .def("__repr__", [name = words.name](OwnQuery& self) {
        return "<softcd." + (name + (" " + nb::cast<std::string>(nb::repr(nb::cast(self.options())))) + ">");
      });
  return query;
}

}  // namespace

void bind_query(nb::module_& module) {
  using namespace nb::literals;
  auto options = nb::class_<QueryOptions>(module, "QueryOptions", "The options of a query.");
  Fields<QueryOptions>().define_value(options);

  bind_query_on<BoundQuery, BoundScene>(
      module,
      {"Query", "Ticket", "scene: Scene, *", "numpy.typing.NDArray[numpy.void] | typing.Any",
       "Finds contacts between the bodies of a scene. The same input gives the same bytes, on any backend, with "
       "any number of threads.",
       "Reads the positions that were set, finds all contacts and returns them as a read-only structured array "
       "(softcd.contact_dtype) over the library's memory, each once, sorted by (kind, body_a, feature_a, body_b, "
       "feature_b). It does not change, whatever happens to the query: other detections use other memory as "
       "long as it lives. With contacts_on_device the result is DeviceContacts instead."})
      .def("set_pair_filter", &BoundQuery::set_pair_filter, "filter"_a.none(),
           "Sets the function filter(a, b) that every later detection asks whether bodies a <= b are compared; None "
           "admits all pairs. It must not call the scene or its queries.")
      .def("set_only_pairs", &BoundQuery::set_only_pairs, "pairs"_a,
           "Restricts later detections to these pairs of bodies; an empty list restricts nothing.");
  bind_query_on<BoundBatchQuery, BoundBatchScene>(
      module, {"BatchQuery", "BatchTicket", "scene: BatchScene, *", "softcd.BatchContacts | typing.Any",
               "Finds contacts within each environment of a BatchScene.",
               "Reads the positions that were set, finds all contacts and returns them as BatchContacts: for each "
               "environment the bytes that a Query returns for a Scene of its own. With contacts_on_device the result "
               "is DeviceContacts instead, sorted by (kind, body, environment, ...), in which body b of environment e "
               "is body b * environments + e."});
}

}  // namespace softcd::python
