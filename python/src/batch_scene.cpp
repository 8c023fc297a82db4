#include "batch_scene.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>

#include "bindings.hpp"
#include "collected.hpp"
#include "contacts.hpp"
#include "fields.hpp"
#include "owned_arrays.hpp"

namespace softcd::python {
namespace {

/// Returns the contacts of a kind whose body_a is this one, of contacts in order.
Span<const Contact> contacts_of(Span<const Contact> contacts, ContactKind kind, BodyId body) {
  const auto is_before = [](const Contact& contact, std::pair<ContactKind, BodyId> place) {
    return std::pair(contact.kind, contact.body_a) < place;
  };
  const Contact* const begin = std::lower_bound(contacts.begin(), contacts.end(), std::pair(kind, body), is_before);
  const Contact* const end =
      std::lower_bound(begin, contacts.end(), std::pair(kind, BodyId{body.value + 1}), is_before);
  return {begin, static_cast<std::size_t>(end - begin)};
}

PyType_Slot batch_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<BoundBatchScene>)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_object<BoundBatchScene>)},
                             {0, nullptr}};

/// Returns settings of a body in one environment.
BodySettings settings_in(std::uint32_t environment, BodySettings settings) {
  settings.batch = environment;
  return settings;
}

void refuse_batch(const BodySettings& settings) {
  if (settings.batch == 0) return;
  throw InvalidInput("batch: a BatchScene gives each environment a batch of its own; leave it out");
}

}  // namespace

BoundBatchScene::BoundBatchScene(std::uint32_t environments, const SceneOptions& options, nb::object log)
    : BoundScene(options, std::move(log)), environments_(environments) {}

std::uint32_t BoundBatchScene::bodies() {
  return call([&](Scene& /*scene*/) { return static_cast<std::uint32_t>(vertex_counts_.size()); });
}

void BoundBatchScene::require_whole() const {
  if (!is_broken_) return;
  throw Error("memory ran out while a body was added to all environments; make another BatchScene.");
}

void BoundBatchScene::require_body(std::uint32_t body) const {
  require_whole();
  if (body < vertex_counts_.size()) return;
  throw InvalidInput(fmt::format("body: there is no body {}; the environments have {}", body, vertex_counts_.size()));
}

std::uint32_t BoundBatchScene::add_bodies(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                                          const BodySettings& settings) {
  refuse_batch(settings);
  const Mesh mesh = read_mesh(triangles, vertex_count, segments);
  return call([&](Scene& scene) {
    require_whole();
    const auto body = static_cast<std::uint32_t>(vertex_counts_.size());
    if ((std::uint64_t{body} + 1) * environments_ >= kNoIndex) {
      throw InvalidInput(
          fmt::format("{} bodies in each of {} environments are too many: 2^32 in all", body + 1, environments_));
    }
    vertex_counts_.reserve(vertex_counts_.size() + 1);
    for (std::uint32_t environment = 0; environment < environments_; ++environment) {
      try {
        scene.add_body(mesh.desc(settings_in(environment, settings)));
      } catch (...) {
        is_broken_ = environment > 0;  // only the first one's arguments can be wrong
        throw;
      }
      count_body(mesh.triangles.size() + mesh.segments.size());
    }
    vertex_counts_.push_back(vertex_count);
    return body;
  });
}

void BoundBatchScene::set_settings(std::uint32_t body, const BodySettings& settings) {
  refuse_batch(settings);
  call([&](Scene& scene) {
    require_body(body);
    for (std::uint32_t environment = 0; environment < environments_; ++environment) {
      scene.set_settings(id_of(body, environment), settings_in(environment, settings));
    }
  });
}

void BoundBatchScene::set_positions(std::uint32_t body, nb::handle vertices_t0, nb::handle vertices_t1,
                                    bool check_finite) {
  const std::uint32_t vertices = call([&](Scene& /*scene*/) {
    require_body(body);
    return vertex_counts_[body];
  });
  PositionsOfCopies t0 = read_positions_of_copies("vertices_t0", vertices_t0, environments_, vertices);
  PositionsOfCopies t1;
  if (!vertices_t1.is_none()) t1 = read_positions_of_copies("vertices_t1", vertices_t1, environments_, vertices);
  if (!t1.of.empty() && t0.memory.dtype() != t1.memory.dtype()) {
    throw nb::type_error(fmt::format("vertices_t1: expected {}, as vertices_t0 has, got {}", dtype_name(t0.memory),
                                     dtype_name(t1.memory))
                             .c_str());
  }
  std::array<Array, 2> arrays = {std::move(t0.memory), std::move(t1.memory)};
  call([&](Scene& scene) {
    for (std::uint32_t environment = 0; environment < environments_ && check_finite; ++environment) {
      require_finite("vertices_t0", t0.of[environment], environment);
      if (!t1.of.empty()) require_finite("vertices_t1", t1.of[environment], environment);
    }
    const bool is_on_device = !t0.of.empty() && t0.of[0].is_on_device();
    set_and_keep(scene, id_of(body, 0).value, is_on_device, arrays, [&](Scene& own) {
      for (std::uint32_t environment = 0; environment < environments_; ++environment) {
        const BodyId id = id_of(body, environment);
        if (t1.of.empty()) {
          own.set_positions(id, t0.of[environment]);
        } else {
          own.set_positions(id, t0.of[environment], t1.of[environment]);
        }
      }
    });
  });
}

void BoundBatchScene::set_ignored_pairs(const NumberPairs& pairs) {
  call([&](Scene& scene) {
    std::vector<BodyPair> ignored;
    ignored.reserve(pairs.size() * environments_);
    for (const auto& [a, b] : pairs) {
      require_body(a);
      require_body(b);
      for (std::uint32_t environment = 0; environment < environments_; ++environment) {
        ignored.push_back({id_of(a, environment), id_of(b, environment)});
      }
    }
    scene.set_ignored_pairs(ignored);
  });
}

void BoundBatchScene::set_vertex_filters(std::uint32_t body, const std::optional<VertexBits>& groups,
                                         const std::optional<VertexBits>& masks) {
  const std::vector<VertexFilter> filters = vertex_filters(groups, masks);
  call([&](Scene& scene) {
    require_body(body);
    if (!filters.empty() && filters.size() != vertex_counts_[body]) {
      throw InvalidInput(fmt::format("groups and masks: expected {}, one for each vertex, got {}", vertex_counts_[body],
                                     filters.size()));
    }
    for (std::uint32_t environment = 0; environment < environments_; ++environment) {
      scene.set_vertex_filters(id_of(body, environment), filters);
    }
  });
}

void BoundBatchScene::set_rest_positions(std::uint32_t body, nb::handle vertices) {
  const PositionsArray rest = vertices.is_none() ? PositionsArray{} : read_positions("vertices", vertices);
  call([&](Scene& scene) {
    require_body(body);
    if (!vertices.is_none() && rest.positions.count() != vertex_counts_[body]) {
      throw InvalidInput(
          fmt::format("vertices: expected shape ({}, 3), got ({}, 3)", vertex_counts_[body], rest.positions.count()));
    }
    for (std::uint32_t environment = 0; environment < environments_; ++environment) {
      scene.set_rest_positions(id_of(body, environment), rest.positions);
    }
  });
}

ContactsOfEnvironments BoundBatchScene::split(Span<const Contact> contacts, std::uint32_t max_threads) const {
  const auto bodies = static_cast<std::uint32_t>(vertex_counts_.size());
  ContactsOfEnvironments result;
  // Not initialized, so that the threads that fill the pages are the first to touch them.
  result.contacts.reset(new std::byte[contacts.size() * sizeof(Contact)]);
  result.begins.assign(std::size_t{environments_} + 1, 0);
  // A query's order is (kind, body_a, ...), so an environment's contacts are a range for each kind and body.
  const auto visit_ranges = [&](std::uint32_t environment, const auto& visit) {
    for (const ContactKind kind : {ContactKind::vertex_triangle, ContactKind::edge_edge}) {
      for (std::uint32_t body = 0; body < bodies; ++body) {
        visit(contacts_of(contacts, kind, id_of(body, environment)));
      }
    }
  };
  const auto count = [&](std::uint32_t environment) {
    visit_ranges(environment, [&](Span<const Contact> range) {
      result.begins[environment + std::size_t{1}] += static_cast<std::int64_t>(range.size());
    });
  };
  const auto copy = [&](std::uint32_t environment) {
    std::byte* next = result.contacts.get() + static_cast<std::size_t>(result.begins[environment]) * sizeof(Contact);
    visit_ranges(environment, [&](Span<const Contact> range) {
      for (Contact contact : range) {
        contact.body_a.value /= environments_;
        contact.body_b.value /= environments_;
        std::memcpy(next, &contact, sizeof(Contact));
        next += sizeof(Contact);
      }
    });
  };
  tbb::task_arena arena(max_threads == 0 ? tbb::task_arena::automatic : static_cast<int>(max_threads));
  arena.execute([&] {
    tbb::parallel_for(0U, environments_, count);
    std::partial_sum(result.begins.begin(), result.begins.end(), result.begins.begin());
    tbb::parallel_for(0U, environments_, copy);
  });
  return result;
}

nb::object contacts_of_environments(ContactsOfEnvironments contacts) {
  const auto count = static_cast<std::size_t>(contacts.begins.back());
  std::byte* const memory = contacts.contacts.get();
  const nb::capsule keeper(memory, [](void* owned) noexcept { delete[] static_cast<std::byte*>(owned); });
  static_cast<void>(contacts.contacts.release());
  const nb::ndarray<nb::numpy, const std::uint8_t, nb::ndim<1>> bytes(reinterpret_cast<const std::uint8_t*>(memory),
                                                                      {count * sizeof(Contact)}, keeper);
  const nb::object all = nb::cast(bytes).attr("view")(contact_dtype());
  const nb::object begins = own<std::int64_t, 1>(std::move(contacts.begins)).attr("reshape")(-1);
  return nb::module_::import_("softcd").attr("BatchContacts")(begins, all);
}

void bind_batch_scene(nb::module_& module) {
  using namespace nb::literals;
  auto scene = nb::class_<BoundBatchScene>(
      module, "BatchScene", nb::type_slots(batch_slots),
      "Holds many environments: copies of the same bodies, with positions of their own. Environments never touch each "
      "other, wherever they are. A BatchQuery finds the contacts of all of them at once. Each environment has the same "
      "bytes as in a Scene of its own. Bodies are numbered from 0, in the order in which they were added.");
  Fields<SceneOptions>().define<BoundBatchScene*, nb::handle, nb::object>(
      scene, "__init__", "environments: int, *, log: collections.abc.Callable[[LogLevel, str], object] | None = None",
      "None",
      [](BoundBatchScene* self, nb::handle environments, nb::object log, const SceneOptions& values) {
        new (self) BoundBatchScene(read_value<std::uint32_t>("environments", environments), values, std::move(log));
      },
      "environments"_a, nb::kw_only(), "log"_a.none() = nb::none(),
      "Makes a scene of so many environments. Further keywords are those of Scene.");
  Fields<BodySettings>().define<BoundBatchScene&, nb::handle, std::uint32_t, nb::handle>(
      scene, "add_body", "triangles: object, vertex_count: int, *, segments: object | None = None", "int",
      [](BoundBatchScene& self, nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
         const BodySettings& settings) { return self.add_bodies(triangles, vertex_count, segments, settings); },
      "triangles"_a, "vertex_count"_a, nb::kw_only(), "segments"_a.none() = nb::none(),
      "Adds a body to every environment, as Scene.add_body does to one, and returns its number. `batch` is left out.");
  Fields<BodySettings>().define<BoundBatchScene&, std::uint32_t>(
      scene, "set_settings", "body: int, *", "None",
      [](BoundBatchScene& self, std::uint32_t body, const BodySettings& settings) {
        self.set_settings(body, settings);
      },
      "body"_a, "Sets all settings of a body in every environment: those that are left out get the defaults.");
  scene
      .def("set_positions", &BoundBatchScene::set_positions, "body"_a, "vertices_t0"_a,
           "vertices_t1"_a.none() = nb::none(), nb::kw_only(), "check_finite"_a = true,
           "Sets a body's positions in all environments: arrays of shape (environments, vertices, 3), otherwise as for "
           "Scene.set_positions. Environments may be any distance apart in memory. numpy.broadcast_to shows the same "
           "positions to all of them without copies.")
      .def("set_ignored_pairs", &BoundBatchScene::set_ignored_pairs, "pairs"_a,
           "Sets the pairs of bodies, or of a body and itself, that are not compared in any environment.")
      .def("set_vertex_filters", &BoundBatchScene::set_vertex_filters, "body"_a, "groups"_a.none() = nb::none(),
           "masks"_a.none() = nb::none(), "Sets filters of the body's vertices, as Scene.set_vertex_filters does.")
      .def("set_rest_positions", &BoundBatchScene::set_rest_positions, "body"_a, "vertices"_a.none(),
           "Sets the body's rest positions, of shape (vertices, 3), for all environments. None removes them.")
      .def_prop_ro("environments", &BoundBatchScene::environments, "The number of environments.")
      .def_prop_ro("bodies", &BoundBatchScene::bodies, "The number of bodies in each environment.")
      .def_prop_ro("options", [](BoundBatchScene& self) { return self.options(); })
      .def_prop_ro(
          "backend", [](BoundBatchScene& self) { return self.backend(); },
          "The backend of the last detection, or the expected one before the first. Never automatic.")
      .def("__repr__", [](BoundBatchScene& self) {
        return fmt::format("<softcd.BatchScene of {} environments of {} bodies, {}>", self.environments(),
                           self.bodies(), nb::cast<std::string>(nb::str(nb::cast(self.backend()))));
      });
}

}  // namespace softcd::python
