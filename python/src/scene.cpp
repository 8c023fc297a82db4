#include "scene.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include "bindings.hpp"
#include "collected.hpp"
#include "fields.hpp"

namespace softcd::python {
namespace {

PyType_Slot scene_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<BoundScene>)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_object<BoundScene>)},
                             {0, nullptr}};

constexpr const char* kSetPositions =
    "Sets the positions of the body's vertices at both ends of the step; without vertices_t1 it does not move. They "
    "are arrays of float32 or float64 of shape (vertices, 3), both of one type and in one place: numpy's, or anything "
    "with __dlpack__ or __cuda_array_interface__. They are not copied. On the CPU they are read when the next "
    "detection is started, and kept alive until then; changes before that count. Lists, other types of numbers, and "
    "rows that do not follow each other, as in Fortran's order, are copied at once. On a GPU they stay in place, and "
    "must not change until others are set. They are read after the work that the device's default stream received "
    "before the detection. With check_finite a coordinate on the CPU that is not finite, or beyond 1e37, is refused. "
    "Without it, and on a GPU, its triangles are left out, with a warning.";

}  // namespace

Mesh read_mesh(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments) {
  Mesh mesh{read_triangles("triangles", triangles), {}, vertex_count};
  if (!segments.is_none()) mesh.segments = read_segments("segments", segments);
  return mesh;
}

std::vector<VertexFilter> vertex_filters(const std::optional<VertexBits>& groups,
                                         const std::optional<VertexBits>& masks) {
  if (groups && masks && groups->shape(0) != masks->shape(0)) {
    throw InvalidInput("groups and masks: expected one of both for each vertex, got " +
                       std::to_string(groups->shape(0)) + " and " + std::to_string(masks->shape(0)));
  }
  std::vector<VertexFilter> filters(groups ? groups->shape(0) : (masks ? masks->shape(0) : 0));
  for (std::size_t v = 0; v < filters.size(); ++v) {
    if (groups) filters[v].group = (*groups)(v);
    if (masks) filters[v].mask = (*masks)(v);
  }
  return filters;
}

BoundScene::BoundScene(const SceneOptions& options, nb::object log)
    : log_(std::move(log)),
      scene_(options, [this](LogLevel level, std::string_view text) { this->log(level, text); }) {}

void BoundScene::log(LogLevel level, std::string_view text) {
  const nb::gil_scoped_acquire interpreter;
  if (log_.is_valid() && !log_.is_none()) {
    log_(level, std::string(text));
  } else if (level == LogLevel::warning) {
    nb::module_::import_("warnings").attr("warn")(std::string(text), nb::handle(PyExc_RuntimeWarning));
  }
}

std::uint32_t BoundScene::add_body(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                                   const BodySettings& settings) {
  const Mesh mesh = read_mesh(triangles, vertex_count, segments);
  return call([&](Scene& scene) {
    const BodyId body = scene.add_body(mesh.desc(settings));
    count_body(mesh.triangles.size() + mesh.segments.size());
    return body.value;
  });
}

void BoundScene::update_body(std::uint32_t body, nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                             nb::handle changed, const BodySettings& settings) {
  const Mesh mesh = read_mesh(triangles, vertex_count, segments);
  std::vector<std::uint32_t> indices;
  if (!changed.is_none()) indices = read_indices("changed", changed);
  call([&](Scene& scene) {
    replaced_.reserve(replaced_.size() + 2);
    if (changed.is_none()) {
      scene.update_body({body}, mesh.desc(settings));
    } else {
      scene.update_body({body}, mesh.desc(settings), indices);
    }
    triangles_given_ += mesh.triangles.size() + mesh.segments.size();
    replace_on_device(body);
  });
}

void BoundScene::set_settings(std::uint32_t body, const BodySettings& settings) {
  call([&](Scene& scene) { scene.set_settings({body}, settings); });
}

void BoundScene::remove_body(std::uint32_t body) {
  call([&](Scene& scene) {
    replaced_.reserve(replaced_.size() + 2);
    scene.remove_body({body});
    replace_on_device(body);
    if (--body_count_ == 0) triangles_given_ = 0;
  });
}

bool BoundScene::has_body(std::uint32_t body) {
  return call([&](Scene& scene) { return scene.has_body({body}); });
}

void BoundScene::set_positions(std::uint32_t body, nb::handle vertices_t0, nb::handle vertices_t1, bool check_finite) {
  PositionsArray t0 = read_positions("vertices_t0", vertices_t0);
  PositionsArray t1 = vertices_t1.is_none() ? t0 : read_positions("vertices_t1", vertices_t1);
  std::array<Array, 2> arrays = {std::move(t0.memory), std::move(t1.memory)};
  call([&](Scene& scene) {
    if (check_finite) {
      require_finite("vertices_t0", t0.positions);
      require_finite("vertices_t1", t1.positions);
    }
    set_and_keep(scene, body, t0.positions.is_on_device(), arrays, [&](Scene& own) {
      if (vertices_t1.is_none()) {
        own.set_positions({body}, t0.positions);
      } else {
        own.set_positions({body}, t0.positions, t1.positions);
      }
    });
  });
}

void BoundScene::set_ignored_pairs(const NumberPairs& pairs) {
  const std::vector<BodyPair> ignored = body_pairs(pairs);
  call([&](Scene& scene) { scene.set_ignored_pairs(ignored); });
}

void BoundScene::set_vertex_filters(std::uint32_t body, const std::optional<VertexBits>& groups,
                                    const std::optional<VertexBits>& masks) {
  const std::vector<VertexFilter> filters = vertex_filters(groups, masks);
  call([&](Scene& scene) { scene.set_vertex_filters({body}, filters); });
}

void BoundScene::set_rest_positions(std::uint32_t body, nb::handle vertices) {
  const PositionsArray rest = vertices.is_none() ? PositionsArray{} : read_positions("vertices", vertices);
  call([&](Scene& scene) { scene.set_rest_positions({body}, rest.positions); });
}

std::unique_lock<std::timed_mutex> BoundScene::lock_between_signals() {
  std::unique_lock lock(mutex_, std::defer_lock);
  while (!lock.try_lock_for(kSignalInterval)) check_signals();
  return lock;
}

/// Releases arrays that have been read. If another call runs, that call or the next one does it.
void BoundScene::release_spent() {
  KeptPositions spent;
  std::vector<Array> on_device;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return;
  spent.swap(spent_);
  on_device.swap(spent_on_device_);
}

/// Replaces a body's arrays on the device. A running detection may still read the old ones, so they are kept. replaced_
/// must have capacity for two more.
void BoundScene::replace_on_device(std::uint32_t body) {
  const auto found = on_device_.find(body);
  if (found == on_device_.end()) return;
  for (Array& array : found->second) replaced_.push_back(std::move(array));
  on_device_.erase(found);
}

SceneOptions BoundScene::options() {
  return call([](Scene& scene) { return scene.options(); });
}

Backend BoundScene::backend() {
  return call([](Scene& scene) { return scene.backend(); });
}

int BoundScene::traverse(visitproc visit, void* arg) {
  Py_VISIT(log_.ptr());
  return 0;
}

void BoundScene::clear() {
  log_.reset();
}

void bind_scene(nb::module_& module) {
  using namespace nb::literals;
  auto options =
      nb::class_<SceneOptions>(module, "SceneOptions", "The processor and the memory for a scene's detections.");
  Fields<SceneOptions>().define_value(options);

  auto scene = nb::class_<BoundScene>(
      module, "Scene", nb::type_slots(scene_slots),
      "Holds bodies, whose contacts queries find. Threads may share one: their calls wait for each other. Every "
      "function may be called while a detection runs; it then concerns the next detection.");
  Fields<SceneOptions>().define<BoundScene*, nb::object>(
      scene, "__init__", "*, log: collections.abc.Callable[[LogLevel, str], object] | None = None", "None",
      [](BoundScene* self, nb::object log, const SceneOptions& values) {
        new (self) BoundScene(values, std::move(log));
      },
      nb::kw_only(), "log"_a.none() = nb::none(),
      "log(level, text) receives warnings and other messages. Without it, warnings are Python's, of the category "
      "RuntimeWarning.");
  Fields<BodySettings>().define<BoundScene&, nb::handle, std::uint32_t, nb::handle>(
      scene, "add_body", "triangles: object, vertex_count: int, *, segments: object | None = None", "int",
      [](BoundScene& self, nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
         const BodySettings& settings) { return self.add_body(triangles, vertex_count, segments, settings); },
      "triangles"_a, "vertex_count"_a, nb::kw_only(), "segments"_a.none() = nb::none(),
      "Adds a mesh, integers of shape (n, 3) over vertices 0 to vertex_count - 1, and returns its number. Segments, of "
      "shape (n, 2), are ropes and hair: edges without a triangle. They touch each other with edge_edge. Where "
      "triangles are counted they follow the triangles.");
  Fields<BodySettings>().define<BoundScene&, std::uint32_t, nb::handle, std::uint32_t, nb::handle, nb::handle>(
      scene, "update_body",
      "body: int, triangles: object, vertex_count: int, *, segments: object | None = None, "
      "changed: object | None = None",
      "None",
      [](BoundScene& self, std::uint32_t body, nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
         nb::handle changed, const BodySettings& settings) {
        self.update_body(body, triangles, vertex_count, segments, changed, settings);
      },
      "body"_a, "triangles"_a, "vertex_count"_a, nb::kw_only(), "segments"_a.none() = nb::none(),
      "changed"_a.none() = nb::none(),
      "Replaces a body's triangles, segments, vertex count and settings. Its positions must be set again. With "
      "`changed`, integers of shape (n,), the cost depends on the size of the change, apart from a copy of the array: "
      "only triangles of these indices, and those behind the last that the body had, may differ from before. Remaining "
      "edges keep their numbers. For a body with segments the whole mesh is read again.");
  Fields<BodySettings>().define<BoundScene&, std::uint32_t>(
      scene, "set_settings", "body: int, *", "None",
      [](BoundScene& self, std::uint32_t body, const BodySettings& settings) { self.set_settings(body, settings); },
      "body"_a, "Sets all settings of a body: those that are left out get the defaults.");
  scene.def("remove_body", &BoundScene::remove_body, "body"_a)
      .def("has_body", &BoundScene::has_body, "body"_a, "Returns whether the body was added and not removed.")
      .def("set_positions", &BoundScene::set_positions, "body"_a, "vertices_t0"_a, "vertices_t1"_a.none() = nb::none(),
           nb::kw_only(), "check_finite"_a = true, kSetPositions)
      .def("set_ignored_pairs", &BoundScene::set_ignored_pairs, "pairs"_a,
           "Sets the pairs of bodies, or of a body and itself, that no query compares from the next detection on. "
           "Replaces the pairs that were set before.")
      .def("set_vertex_filters", &BoundScene::set_vertex_filters, "body"_a, "groups"_a.none() = nb::none(),
           "masks"_a.none() = nb::none(),
           "Sets filters of the body's vertices: one uint32 for each vertex, copied. Features may touch where some "
           "vertex v of the one and some vertex w of the other have groups[v] & masks[w] and groups[w] & masks[v]. "
           "Missing groups are 1, missing masks all bits; without both the body has no filters.")
      .def("set_rest_positions", &BoundScene::set_rest_positions, "body"_a, "vertices"_a.none(),
           "Sets the body's rest positions, for its rest_distance: as for set_positions, on the CPU, and copied. None "
           "removes them.")
      .def_prop_ro("options", &BoundScene::options)
      .def_prop_ro("backend", &BoundScene::backend,
                   "The backend of the last detection, or the expected one before the first. Never automatic.")
      .def("__len__", &BoundScene::body_count)
      .def("__repr__", [](BoundScene& self) {
        const std::string bodies = std::to_string(self.body_count());
        return "<softcd.Scene of " + bodies + (self.body_count() == 1 ? " body, " : " bodies, ") +
               nb::cast<std::string>(nb::str(nb::cast(self.backend()))) + ">";
      });
}

}  // namespace softcd::python
