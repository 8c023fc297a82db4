#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "collected.hpp"
#include "keywords.hpp"
#include "owned_arrays.hpp"
#include "scene.hpp"

namespace softcd::python {
namespace {

nb::object make_dtype(const RayHit* /*type*/) {
  StructLayout layout;
  layout.add("body", "=u4", offsetof(RayHit, body));
  layout.add("triangle", "=u4", offsetof(RayHit, triangle));
  layout.add("t", "=f8", offsetof(RayHit, t));
  layout.add("weights", "=f4", 3, offsetof(RayHit, weights));
  layout.add("normal", "=f4", 3, offsetof(RayHit, normal));
  return layout.dtype(sizeof(RayHit));
}

nb::object make_dtype(const ClosestPoint* /*type*/) {
  StructLayout layout;
  layout.add("body", "=u4", offsetof(ClosestPoint, body));
  layout.add("triangle", "=u4", offsetof(ClosestPoint, triangle));
  layout.add("position", "=f8", 3, offsetof(ClosestPoint, position));
  layout.add("distance", "=f8", offsetof(ClosestPoint, distance));
  layout.add("weights", "=f4", 3, offsetof(ClosestPoint, weights));
  layout.add("side", "=i4", offsetof(ClosestPoint, side));
  return layout.dtype(sizeof(ClosestPoint));
}

nb::object make_dtype(const TriangleOverlap* /*type*/) {
  StructLayout layout;
  layout.add("body", "=u4", offsetof(TriangleOverlap, body));
  layout.add("triangle", "=u4", offsetof(TriangleOverlap, triangle));
  return layout.dtype(sizeof(TriangleOverlap));
}

nb::object make_dtype(const BodyDistance* /*type*/) {
  StructLayout layout;
  layout.add("body_a", "=u4", offsetof(BodyDistance, body_a));
  layout.add("body_b", "=u4", offsetof(BodyDistance, body_b));
  layout.add("triangle_a", "=u4", offsetof(BodyDistance, triangle_a));
  layout.add("triangle_b", "=u4", offsetof(BodyDistance, triangle_b));
  layout.add("position_a", "=f8", 3, offsetof(BodyDistance, position_a));
  layout.add("position_b", "=f8", 3, offsetof(BodyDistance, position_b));
  layout.add("distance", "=f8", offsetof(BodyDistance, distance));
  layout.add("weights_a", "=f4", 3, offsetof(BodyDistance, weights_a));
  layout.add("weights_b", "=f4", 3, offsetof(BodyDistance, weights_b));
  return layout.dtype(sizeof(BodyDistance));
}

nb::object make_dtype(const TriangleIntersection* /*type*/) {
  StructLayout layout;
  layout.add("body_a", "=u4", offsetof(TriangleIntersection, body_a));
  layout.add("triangle_a", "=u4", offsetof(TriangleIntersection, triangle_a));
  layout.add("body_b", "=u4", offsetof(TriangleIntersection, body_b));
  layout.add("triangle_b", "=u4", offsetof(TriangleIntersection, triangle_b));
  return layout.dtype(sizeof(TriangleIntersection));
}

nb::object make_dtype(const CurvePoint* /*type*/) {
  StructLayout layout;
  layout.add("position", "=f8", 3, offsetof(CurvePoint, position));
  layout.add("edge_body", "=u4", offsetof(CurvePoint, edge_body));
  layout.add("edge", "=u4", 2, offsetof(CurvePoint, edge));
  layout.add("triangle_body", "=u4", offsetof(CurvePoint, triangle_body));
  layout.add("triangle", "=u4", offsetof(CurvePoint, triangle));
  return layout.dtype(sizeof(CurvePoint));
}

nb::object make_dtype(const IntersectionCurve* /*type*/) {
  StructLayout layout;
  layout.add("body_a", "=u4", offsetof(IntersectionCurve, body_a));
  layout.add("body_b", "=u4", offsetof(IntersectionCurve, body_b));
  layout.add("is_closed", "?", offsetof(IntersectionCurve, is_closed));
  layout.add("is_perturbed", "?", offsetof(IntersectionCurve, is_perturbed));
  layout.add("first_point", "=u4", offsetof(IntersectionCurve, first_point));
  layout.add("point_count", "=u4", offsetof(IntersectionCurve, point_count));
  layout.add("length", "=f8", offsetof(IntersectionCurve, length));
  return layout.dtype(sizeof(IntersectionCurve));
}

nb::object make_dtype(const RegionVertex* /*type*/) {
  StructLayout layout;
  layout.add("vertex", "=u4", offsetof(RegionVertex, vertex));
  layout.add("direction", "=f8", 3, offsetof(RegionVertex, direction));
  layout.add("distance", "=f8", offsetof(RegionVertex, distance));
  return layout.dtype(sizeof(RegionVertex));
}

nb::object make_dtype(const IntersectionRegion* /*type*/) {
  StructLayout layout;
  layout.add("body", "=u4", offsetof(IntersectionRegion, body));
  layout.add("other", "=u4", offsetof(IntersectionRegion, other));
  layout.add("kind", "=u4", offsetof(IntersectionRegion, kind));
  layout.add("is_inside", "?", offsetof(IntersectionRegion, is_inside));
  layout.add("is_perturbed", "?", offsetof(IntersectionRegion, is_perturbed));
  layout.add("first_vertex", "=u4", offsetof(IntersectionRegion, first_vertex));
  layout.add("vertex_count", "=u4", offsetof(IntersectionRegion, vertex_count));
  layout.add("first_triangle", "=u4", offsetof(IntersectionRegion, first_triangle));
  layout.add("triangle_count", "=u4", offsetof(IntersectionRegion, triangle_count));
  layout.add("first_curve", "=u4", offsetof(IntersectionRegion, first_curve));
  layout.add("curve_count", "=u4", offsetof(IntersectionRegion, curve_count));
  layout.add("area", "=f8", offsetof(IntersectionRegion, area));
  layout.add("curve_length", "=f8", offsetof(IntersectionRegion, curve_length));
  return layout.dtype(sizeof(IntersectionRegion));
}

nb::object make_dtype(const ChangeIntersection* /*type*/) {
  StructLayout layout;
  layout.add("added", "=u4", offsetof(ChangeIntersection, added));
  layout.add("body", "=u4", offsetof(ChangeIntersection, body));
  layout.add("triangle", "=u4", offsetof(ChangeIntersection, triangle));
  return layout.dtype(sizeof(ChangeIntersection));
}

template <class Answer>
nb::object own_answers(std::vector<Answer> answers) {
  static const nb::object* const dtype = new nb::object(make_dtype(static_cast<const Answer*>(nullptr)));
  return own_structs(std::move(answers), *dtype);
}

/// A batch of questions, all members of which are doubles.
template <class Question>
using Batch =
    nb::ndarray<const double, nb::shape<-1, sizeof(Question) / sizeof(double)>, nb::c_contig, nb::device::cpu>;

/// One number for each question, or, without dimensions, one for all.
using Radii = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

template <class Question>
Span<const Question> questions_in(const Batch<Question>& batch) {
  return {reinterpret_cast<const Question*>(batch.data()), batch.shape(0)};
}

/// Returns the hulls. Hull i has the points from begins[i] up to, but without, begins[i + 1]; a single radius is for
/// all.
std::vector<ProbeHull> hulls_in(const Batch<Vec3d>& points, const std::vector<std::uint32_t>& begins,
                                const Radii& radii) {
  if (begins.empty()) throw InvalidInput("begins: expected shape (n + 1,) for n hulls, got (0,)");
  if (begins.front() != 0 || begins.back() != points.shape(0)) {
    throw InvalidInput(fmt::format("begins: expected 0 first, and {}, the number of points, last, got {} and {}",
                                   points.shape(0), begins.front(), begins.back()));
  }
  const std::size_t count = begins.size() - 1;
  if (radii.ndim() > 0 && radii.size() != count) {
    throw InvalidInput(fmt::format("radii: expected {} rows, as begins has hulls, got {}", count, radii.size()));
  }
  const Span<const Vec3d> all = questions_in<Vec3d>(points);
  std::vector<ProbeHull> hulls(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (begins[i] > begins[i + 1]) {
      throw InvalidInput(
          fmt::format("begins: row {} is {}, which is less than {} before it", i + 1, begins[i + 1], begins[i]));
    }
    hulls[i] = {{all.data() + begins[i], begins[i + 1] - begins[i]}, radii.data()[radii.ndim() > 0 ? i : 0]};
  }
  return hulls;
}

/// Pairs of bodies; a missing body stands for all.
using AskedPairs = std::vector<std::pair<std::optional<std::uint32_t>, std::optional<std::uint32_t>>>;

ProbeBodies asked_pair(std::optional<std::uint32_t> a, std::optional<std::uint32_t> b) {
  return {{a.value_or(kNoIndex)}, {b.value_or(kNoIndex)}};
}

std::vector<ProbeBodies> asked_pairs(const AskedPairs& numbers) {
  std::vector<ProbeBodies> pairs;
  pairs.reserve(numbers.size());
  for (const auto& [a, b] : numbers) pairs.push_back(asked_pair(a, b));
  return pairs;
}

/// A ProbeChange with its data.
struct MeshChange {
  std::uint32_t body;
  std::vector<std::uint32_t> removed;
  std::vector<Triangle> added;
  std::vector<Vec3d> new_vertices;
};

MeshChange make_change(std::uint32_t body, nb::handle removed, nb::handle added, nb::handle new_vertices) {
  MeshChange change{body, {}, {}, {}};
  if (!removed.is_none()) change.removed = read_indices("removed", removed);
  if (!added.is_none()) change.added = read_triangles("added", added);
  if (!new_vertices.is_none()) change.new_vertices = read_points("new_vertices", new_vertices);
  return change;
}

std::string describe(const MeshChange& change) {
  return fmt::format("<softcd.MeshChange of body {}: {} triangles removed, {} added, {} new vertices>", change.body,
                     change.removed.size(), change.added.size(), change.new_vertices.size());
}

template <class Answer>
std::vector<Answer> copy(Span<const Answer> answers) {
  return {answers.begin(), answers.end()};
}
/// Copies the begins of all lists, and all results.
template <class Answer>
auto copy(const softcd::AnswerLists<Answer>& lists) {
  std::vector<std::uint64_t> begins(lists.begins().begin(), lists.begins().end());
  if (begins.empty()) begins.push_back(0);
  return std::pair(std::move(begins), copy(lists.all()));
}

/// Copies of all arrays of IntersectionRegions.
struct CopiedRegions {
  std::vector<IntersectionRegion> regions;
  std::vector<RegionVertex> vertices;
  std::vector<std::uint32_t> triangles, region_curves;
  std::vector<IntersectionCurve> curves;
  std::vector<CurvePoint> points;
  std::uint64_t touching_pairs;
};
CopiedRegions copy(const IntersectionRegions& found) {
  return {copy(found.regions), copy(found.vertices), copy(found.triangles), copy(found.region_curves),
          copy(found.curves),  copy(found.points),   found.touching_pairs};
}

/// softcd::Probe for Python, which keeps its scene alive. Results are copied before the next call.
class BoundProbe {
 public:
  BoundProbe(nb::object scene, StepEnd step_end) : object_(std::move(scene)), scene_(nb::cast<BoundScene&>(object_)) {
    scene_.call([&](Scene& bound) {
      auto probe = std::make_shared<Probe>(bound, ProbeOptions{step_end});
      probe_ = probe.get();
      discardable_.push_back(std::move(probe));
    });
  }
  BoundProbe(const BoundProbe&) = delete;
  BoundProbe& operator=(const BoundProbe&) = delete;
  ~BoundProbe() { scene_.discarded()->add(discardable_); }

  nb::object first_hits(const Batch<Ray>& rays) {
    return ask_each(rays.shape(0), [this, rays] { return copy(probe_->first_hits(questions_in<Ray>(rays))); });
  }
  nb::tuple all_hits(const Batch<Ray>& rays) {
    return ask_lists(rays.shape(0), [this, rays] { return copy(probe_->all_hits(questions_in<Ray>(rays))); });
  }
  nb::object closest_points(const Batch<ProbePoint>& points) {
    return ask_each(points.shape(0),
                    [this, points] { return copy(probe_->closest_points(questions_in<ProbePoint>(points))); });
  }
  template <class Shape>
  nb::tuple overlaps(const Batch<Shape>& shapes) {
    return ask_lists(shapes.shape(0), [this, shapes] { return copy(probe_->overlaps(questions_in<Shape>(shapes))); });
  }
  nb::tuple hull_overlaps(const Batch<Vec3d>& points, nb::handle begins, const Radii& radii) {
    auto hulls = hulls_in(points, read_indices("begins", begins), radii);
    const std::size_t count = hulls.size();
    return ask_lists(count, [this, points, hulls = std::move(hulls)] { return copy(probe_->overlaps(hulls)); });
  }
  nb::object distances(const AskedPairs& pairs) {
    return ask_each(pairs_of_triangles(pairs),
                    [this, asked = asked_pairs(pairs)] { return copy(probe_->distances(asked)); });
  }
  nb::tuple intersections(const AskedPairs& pairs) {
    return ask_lists(pairs_of_triangles(pairs),
                     [this, asked = asked_pairs(pairs)] { return copy(probe_->intersections(asked)); });
  }
  bool has_intersections(std::optional<std::uint32_t> a, std::optional<std::uint32_t> b) {
    return scene_.call_and_read(nb::find(this),
                                [this, asked = asked_pair(a, b)](Scene&) { return probe_->has_intersections(asked); });
  }
  nb::tuple intersection_regions(std::optional<std::uint32_t> a, std::optional<std::uint32_t> b) {
    CopiedRegions found = scene_.call_and_read(
        nb::find(this), [this, asked = asked_pair(a, b)](Scene&) { return copy(probe_->intersection_regions(asked)); });
    return nb::make_tuple(own_answers(std::move(found.regions)), own_answers(std::move(found.vertices)),
                          own<std::uint32_t, 1>(std::move(found.triangles)).attr("ravel")(),
                          own<std::uint32_t, 1>(std::move(found.region_curves)).attr("ravel")(),
                          own_answers(std::move(found.curves)), own_answers(std::move(found.points)),
                          found.touching_pairs);
  }
  nb::tuple intersections_after(const std::vector<MeshChange>& changes) {
    return ask_lists(changes.size(), [this, changes] {
      std::vector<ProbeChange> asked;
      asked.reserve(changes.size());
      for (const MeshChange& change : changes) {
        asked.push_back({{change.body}, change.removed, change.added, change.new_vertices});
      }
      return copy(probe_->intersections_after(asked));
    });
  }
  void set_body_filter(nb::object filter) {
    BodyFilter asked;
    if (!filter.is_none()) asked = [this](BodyId body) { return is_asked_about(body); };
    scene_.call([&](Scene&) {
      probe_->set_body_filter(std::move(asked));
      std::swap(filter_, filter);
    });
  }

  int traverse(visitproc visit, void* arg) {
    Py_VISIT(object_.ptr());
    Py_VISIT(filter_.ptr());
    return 0;
  }
  /// Breaks cycles, which lead through the filter.
  void clear() { filter_.reset(); }

 private:
  /// Returns an upper bound of the number of pairs of triangles: a pair of bodies has one for each triangle.
  std::size_t pairs_of_triangles(const AskedPairs& pairs) const {
    return pairs.size() * std::max<std::size_t>(scene_.triangles_given(), 1);
  }
  /// Returns the result of `ask`. Without questions a probe reads no positions.
  template <class Ask>
  auto answer(std::size_t questions, Ask ask) {
    auto asked = [ask = std::move(ask)](Scene&) { return ask(); };
    const nb::handle self = nb::find(this);
    return questions > 0 ? scene_.call_and_read(self, std::move(asked), questions) : scene_.call(std::move(asked));
  }
  template <class Ask>
  nb::object ask_each(std::size_t questions, Ask ask) {
    return own_answers(answer(questions, std::move(ask)));
  }
  template <class Ask>
  nb::tuple ask_lists(std::size_t questions, Ask ask) {
    auto [begins, answers] = answer(questions, std::move(ask));
    return nb::make_tuple(own<std::int64_t, 1>(std::move(begins)).attr("ravel")(), own_answers(std::move(answers)));
  }
  bool is_asked_about(BodyId body) {
    const nb::gil_scoped_acquire interpreter;
    if (!filter_.is_valid()) return true;
    return nb::cast<bool>(nb::bool_(filter_(body.value)));
  }

  nb::object object_;
  BoundScene& scene_;
  Discardable discardable_;  ///< the probe
  Probe* probe_ = nullptr;
  nb::object filter_;
};

PyType_Slot probe_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(traverse_object<BoundProbe>)},
                             {Py_tp_clear, reinterpret_cast<void*>(clear_object<BoundProbe>)},
                             {0, nullptr}};

}  // namespace

void bind_probe(nb::module_& module) {
  using namespace nb::literals;
  module.attr("NO_BODY") = kNoIndex;
  nb::class_<MeshChange>(module, "MeshChange",
                         "A possible change of one body's mesh: an edge split, collapsed or flipped, a hole filled.")
      .def(
          "__init__",
          [](MeshChange* self, std::uint32_t body, nb::handle removed, nb::handle added, nb::handle new_vertices) {
            new (self) MeshChange(make_change(body, removed, added, new_vertices));
          },
          "body"_a, "removed"_a.none() = nb::none(), "added"_a.none() = nb::none(),
          "new_vertices"_a.none() = nb::none(),
          "removed, integers of shape (n,), are triangles of the body that would not be there any more; added, of "
          "shape (n, 3), what would come instead. New vertex i, in new_vertices of float32 or float64 of shape "
          "(n, 3), has the index `vertex count of the body + i`; a vertex that would move is a new one. All are "
          "copied.")
      .def("__repr__", describe);

  nb::class_<BoundProbe>(module, "Probe", nb::type_slots(probe_slots), "What softcd.Probe asks.")
      .def(
          "__init__",
          [](BoundProbe* self, nb::handle_t<BoundScene> scene, nb::handle step_end) {
            new (self) BoundProbe(nb::borrow(scene), read_enumerator<StepEnd>("step_end", step_end));
          },
          "scene"_a, "step_end"_a)
      .def("first_hits", &BoundProbe::first_hits, "rays"_a)
      .def("all_hits", &BoundProbe::all_hits, "rays"_a)
      .def("closest_points", &BoundProbe::closest_points, "points"_a)
      .def("sphere_overlaps", &BoundProbe::overlaps<ProbeSphere>, "spheres"_a)
      .def("capsule_overlaps", &BoundProbe::overlaps<ProbeCapsule>, "capsules"_a)
      .def("box_overlaps", &BoundProbe::overlaps<ProbeBox>, "boxes"_a)
      .def("oriented_box_overlaps", &BoundProbe::overlaps<ProbeOrientedBox>, "boxes"_a)
      .def("hull_overlaps", &BoundProbe::hull_overlaps, "points"_a, "begins"_a, "radii"_a)
      .def("distances", &BoundProbe::distances, "pairs"_a)
      .def("intersections", &BoundProbe::intersections, "pairs"_a)
      .def("has_intersections", &BoundProbe::has_intersections, "a"_a.none(), "b"_a.none())
      .def("intersection_regions", &BoundProbe::intersection_regions, "a"_a.none(), "b"_a.none())
      .def("intersections_after", &BoundProbe::intersections_after, "changes"_a)
      .def("set_body_filter", &BoundProbe::set_body_filter, "filter"_a.none());
}

}  // namespace softcd::python
