#include <cstddef>
#include <utility>
#include <vector>

#include "c_interface.hpp"

namespace softcd::c_interface {
namespace {

static_assert(sizeof(softcd_ray) == sizeof(Ray) && offsetof(softcd_ray, direction) == offsetof(Ray, direction) &&
              offsetof(softcd_ray, t_min) == offsetof(Ray, t_min) &&
              offsetof(softcd_ray, t_max) == offsetof(Ray, t_max));
static_assert(sizeof(softcd_ray_hit) == sizeof(RayHit) &&
              offsetof(softcd_ray_hit, triangle) == offsetof(RayHit, triangle) &&
              offsetof(softcd_ray_hit, t) == offsetof(RayHit, t) &&
              offsetof(softcd_ray_hit, weights) == offsetof(RayHit, weights) &&
              offsetof(softcd_ray_hit, normal) == offsetof(RayHit, normal));
static_assert(sizeof(softcd_point) == sizeof(ProbePoint) &&
              offsetof(softcd_point, max_distance) == offsetof(ProbePoint, max_distance));
static_assert(sizeof(softcd_closest_point) == sizeof(ClosestPoint) &&
              offsetof(softcd_closest_point, triangle) == offsetof(ClosestPoint, triangle) &&
              offsetof(softcd_closest_point, position) == offsetof(ClosestPoint, position) &&
              offsetof(softcd_closest_point, distance) == offsetof(ClosestPoint, distance) &&
              offsetof(softcd_closest_point, weights) == offsetof(ClosestPoint, weights) &&
              offsetof(softcd_closest_point, side) == offsetof(ClosestPoint, side));
static_assert(sizeof(softcd_sphere) == sizeof(ProbeSphere) &&
              offsetof(softcd_sphere, radius) == offsetof(ProbeSphere, radius));
static_assert(sizeof(softcd_capsule) == sizeof(ProbeCapsule) &&
              offsetof(softcd_capsule, to) == offsetof(ProbeCapsule, to) &&
              offsetof(softcd_capsule, radius) == offsetof(ProbeCapsule, radius));
static_assert(sizeof(softcd_box) == sizeof(ProbeBox) && offsetof(softcd_box, hi) == offsetof(ProbeBox, hi));
static_assert(sizeof(softcd_oriented_box) == sizeof(ProbeOrientedBox) &&
              offsetof(softcd_oriented_box, half) == offsetof(ProbeOrientedBox, half) &&
              offsetof(softcd_oriented_box, axes) == offsetof(ProbeOrientedBox, axes));
static_assert(sizeof(softcd_overlap) == sizeof(TriangleOverlap) &&
              offsetof(softcd_overlap, triangle) == offsetof(TriangleOverlap, triangle));

static_assert(sizeof(softcd_body_pair) == sizeof(ProbeBodies) &&
              offsetof(softcd_body_pair, b) == offsetof(ProbeBodies, b));
static_assert(sizeof(softcd_body_distance) == sizeof(BodyDistance) &&
              offsetof(softcd_body_distance, body_b) == offsetof(BodyDistance, body_b) &&
              offsetof(softcd_body_distance, triangle_a) == offsetof(BodyDistance, triangle_a) &&
              offsetof(softcd_body_distance, triangle_b) == offsetof(BodyDistance, triangle_b) &&
              offsetof(softcd_body_distance, position_a) == offsetof(BodyDistance, position_a) &&
              offsetof(softcd_body_distance, position_b) == offsetof(BodyDistance, position_b) &&
              offsetof(softcd_body_distance, distance) == offsetof(BodyDistance, distance) &&
              offsetof(softcd_body_distance, weights_a) == offsetof(BodyDistance, weights_a) &&
              offsetof(softcd_body_distance, weights_b) == offsetof(BodyDistance, weights_b));
static_assert(sizeof(softcd_intersection) == sizeof(TriangleIntersection) &&
              offsetof(softcd_intersection, triangle_a) == offsetof(TriangleIntersection, triangle_a) &&
              offsetof(softcd_intersection, body_b) == offsetof(TriangleIntersection, body_b) &&
              offsetof(softcd_intersection, triangle_b) == offsetof(TriangleIntersection, triangle_b));
static_assert(sizeof(softcd_curve_point) == sizeof(CurvePoint) &&
              offsetof(softcd_curve_point, edge_body) == offsetof(CurvePoint, edge_body) &&
              offsetof(softcd_curve_point, edge) == offsetof(CurvePoint, edge) &&
              offsetof(softcd_curve_point, triangle_body) == offsetof(CurvePoint, triangle_body) &&
              offsetof(softcd_curve_point, triangle) == offsetof(CurvePoint, triangle));
static_assert(sizeof(softcd_intersection_curve) == sizeof(IntersectionCurve) &&
              offsetof(softcd_intersection_curve, body_b) == offsetof(IntersectionCurve, body_b) &&
              offsetof(softcd_intersection_curve, is_closed) == offsetof(IntersectionCurve, is_closed) &&
              offsetof(softcd_intersection_curve, is_perturbed) == offsetof(IntersectionCurve, is_perturbed) &&
              offsetof(softcd_intersection_curve, first_point) == offsetof(IntersectionCurve, first_point) &&
              offsetof(softcd_intersection_curve, point_count) == offsetof(IntersectionCurve, point_count) &&
              offsetof(softcd_intersection_curve, length) == offsetof(IntersectionCurve, length));
static_assert(sizeof(softcd_region_vertex) == sizeof(RegionVertex) &&
              offsetof(softcd_region_vertex, direction) == offsetof(RegionVertex, direction) &&
              offsetof(softcd_region_vertex, distance) == offsetof(RegionVertex, distance));
static_assert(sizeof(softcd_intersection_region) == sizeof(IntersectionRegion) &&
              offsetof(softcd_intersection_region, other) == offsetof(IntersectionRegion, other) &&
              offsetof(softcd_intersection_region, kind) == offsetof(IntersectionRegion, kind) &&
              offsetof(softcd_intersection_region, is_inside) == offsetof(IntersectionRegion, is_inside) &&
              offsetof(softcd_intersection_region, is_perturbed) == offsetof(IntersectionRegion, is_perturbed) &&
              offsetof(softcd_intersection_region, first_vertex) == offsetof(IntersectionRegion, first_vertex) &&
              offsetof(softcd_intersection_region, vertex_count) == offsetof(IntersectionRegion, vertex_count) &&
              offsetof(softcd_intersection_region, first_triangle) == offsetof(IntersectionRegion, first_triangle) &&
              offsetof(softcd_intersection_region, triangle_count) == offsetof(IntersectionRegion, triangle_count) &&
              offsetof(softcd_intersection_region, first_curve) == offsetof(IntersectionRegion, first_curve) &&
              offsetof(softcd_intersection_region, curve_count) == offsetof(IntersectionRegion, curve_count) &&
              offsetof(softcd_intersection_region, area) == offsetof(IntersectionRegion, area) &&
              offsetof(softcd_intersection_region, curve_length) == offsetof(IntersectionRegion, curve_length));
static_assert(SOFTCD_REGION_LOOP_WITH_BORDER == static_cast<int>(RegionKind::loop_with_border) &&
              SOFTCD_REGION_DEGENERATE == static_cast<int>(RegionKind::degenerate));
static_assert(sizeof(softcd_change_intersection) == sizeof(ChangeIntersection) &&
              offsetof(softcd_change_intersection, body) == offsetof(ChangeIntersection, body) &&
              offsetof(softcd_change_intersection, triangle) == offsetof(ChangeIntersection, triangle));

/// Converts a hull, without copying the caller's points.
ProbeHull query_hull(const softcd_hull& given) {
  return {rows<Vec3d>(given.points, given.point_count, "points"), given.radius};
}
ProbeChange query_change(const softcd_change& given) {
  return {{given.body},
          elements<std::uint32_t>(given.removed, given.removed_count, "removed"),
          rows<Triangle>(given.added, given.added_count, "added"),
          rows<Vec3d>(given.new_vertices, given.new_vertex_count, "new_vertices")};
}

/// Writes the results of `ask(probe)`: one for each question, or lists of them.
template <class Answer, class Ask>
softcd_status ask_each(softcd_probe* probe, const Answer** answers, const Ask& ask) noexcept {
  return guarded_call([&] {
    const Answer*& out = result(answers, "answers");
    out = reinterpret_cast<const Answer*>(ask(required(probe, "probe").probe).data());
  });
}
template <class Answer, class Ask>
softcd_status ask_lists(softcd_probe* probe, const uint64_t** begins, const Answer** answers, const Ask& ask) noexcept {
  return guarded_call([&] {
    const uint64_t*& out_begins = result(begins, "begins");
    const Answer*& out = result(answers, "answers");
    const auto found = ask(required(probe, "probe").probe);
    out_begins = found.begins().data();
    out = reinterpret_cast<const Answer*>(found.all().data());
  });
}

}  // namespace
}  // namespace softcd::c_interface

namespace c = softcd::c_interface;

softcd_status softcd_probe_create(softcd_scene* scene, softcd_step_end step_end, softcd_probe** probe) {
  return c::guarded_call([&] {
    softcd_probe*& out = c::result(probe, "probe");
    const softcd::ProbeOptions options = {static_cast<softcd::StepEnd>(step_end)};
    out = new softcd_probe{softcd::Probe(c::required(scene, "scene").scene, options)};
  });
}

void softcd_probe_destroy(softcd_probe* probe) {
  delete probe;
}

softcd_status softcd_probe_set_body_filter(softcd_probe* probe, softcd_body_filter filter, void* user_data) {
  return c::guarded_call([&] {
    softcd::BodyFilter callback;
    if (filter != nullptr) {
      callback = [filter, user_data](softcd::BodyId body) { return filter(user_data, body.value) != 0; };
    }
    c::required(probe, "probe").probe.set_body_filter(std::move(callback));
  });
}

softcd_status softcd_probe_first_hits(softcd_probe* probe, const softcd_ray* rays, uint64_t count,
                                      const softcd_ray_hit** hits) {
  return c::ask_each(probe, hits, [&](softcd::Probe& asked) {
    return asked.first_hits(c::elements<softcd::Ray>(rays, count, "rays"));
  });
}

softcd_status softcd_probe_all_hits(softcd_probe* probe, const softcd_ray* rays, uint64_t count,
                                    const uint64_t** begins, const softcd_ray_hit** hits) {
  return c::ask_lists(probe, begins, hits, [&](softcd::Probe& asked) {
    return asked.all_hits(c::elements<softcd::Ray>(rays, count, "rays"));
  });
}

softcd_status softcd_probe_closest_points(softcd_probe* probe, const softcd_point* points, uint64_t count,
                                          const softcd_closest_point** closest) {
  return c::ask_each(probe, closest, [&](softcd::Probe& asked) {
    return asked.closest_points(c::elements<softcd::ProbePoint>(points, count, "points"));
  });
}

softcd_status softcd_probe_sphere_overlaps(softcd_probe* probe, const softcd_sphere* spheres, uint64_t count,
                                           const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::ProbeSphere>(spheres, count, "spheres"));
  });
}

softcd_status softcd_probe_capsule_overlaps(softcd_probe* probe, const softcd_capsule* capsules, uint64_t count,
                                            const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::ProbeCapsule>(capsules, count, "capsules"));
  });
}

softcd_status softcd_probe_box_overlaps(softcd_probe* probe, const softcd_box* boxes, uint64_t count,
                                        const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::ProbeBox>(boxes, count, "boxes"));
  });
}

softcd_status softcd_probe_oriented_box_overlaps(softcd_probe* probe, const softcd_oriented_box* boxes, uint64_t count,
                                                 const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::ProbeOrientedBox>(boxes, count, "boxes"));
  });
}

softcd_status softcd_probe_hull_overlaps(softcd_probe* probe, const softcd_hull* hulls, uint64_t count,
                                         const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    std::vector<softcd::ProbeHull> asked_about;
    for (const softcd_hull& hull : c::elements<softcd_hull>(hulls, count, "hulls")) {
      asked_about.push_back(c::query_hull(hull));
    }
    return asked.overlaps(asked_about);
  });
}

softcd_status softcd_probe_distances(softcd_probe* probe, const softcd_body_pair* pairs, uint64_t count,
                                     const softcd_body_distance** distances) {
  return c::ask_each(probe, distances, [&](softcd::Probe& asked) {
    return asked.distances(c::elements<softcd::ProbeBodies>(pairs, count, "pairs"));
  });
}

softcd_status softcd_probe_intersections(softcd_probe* probe, const softcd_body_pair* pairs, uint64_t count,
                                         const uint64_t** begins, const softcd_intersection** intersections) {
  return c::ask_lists(probe, begins, intersections, [&](softcd::Probe& asked) {
    return asked.intersections(c::elements<softcd::ProbeBodies>(pairs, count, "pairs"));
  });
}

softcd_status softcd_probe_has_intersections(softcd_probe* probe, const softcd_body_pair* pair,
                                             uint32_t* has_intersections) {
  return c::guarded_call([&] {
    uint32_t& out = c::result(has_intersections, "has_intersections");
    const softcd::ProbeBodies bodies =
        pair != nullptr ? softcd::ProbeBodies{{pair->a}, {pair->b}} : softcd::ProbeBodies();
    out = c::required(probe, "probe").probe.has_intersections(bodies) ? 1 : 0;
  });
}

softcd_status softcd_probe_intersection_regions(softcd_probe* probe, const softcd_body_pair* pair,
                                                softcd_intersection_regions* regions) {
  return c::guarded_call([&] {
    softcd_intersection_regions& out = c::result(regions, "regions");
    const softcd::ProbeBodies bodies =
        pair != nullptr ? softcd::ProbeBodies{{pair->a}, {pair->b}} : softcd::ProbeBodies();
    const softcd::IntersectionRegions found = c::required(probe, "probe").probe.intersection_regions(bodies);
    out.regions = reinterpret_cast<const softcd_intersection_region*>(found.regions.data());
    out.vertices = reinterpret_cast<const softcd_region_vertex*>(found.vertices.data());
    out.triangles = found.triangles.data();
    out.region_curves = found.region_curves.data();
    out.curves = reinterpret_cast<const softcd_intersection_curve*>(found.curves.data());
    out.points = reinterpret_cast<const softcd_curve_point*>(found.points.data());
    out.region_count = found.regions.size();
    out.curve_count = found.curves.size();
    out.touching_pairs = found.touching_pairs;
  });
}

softcd_status softcd_probe_intersections_after(softcd_probe* probe, const softcd_change* changes, uint64_t count,
                                               const uint64_t** begins,
                                               const softcd_change_intersection** intersections) {
  return c::ask_lists(probe, begins, intersections, [&](softcd::Probe& asked) {
    std::vector<softcd::ProbeChange> asked_about;
    for (const softcd_change& change : c::elements<softcd_change>(changes, count, "changes")) {
      asked_about.push_back(c::query_change(change));
    }
    return asked.intersections_after(asked_about);
  });
}
