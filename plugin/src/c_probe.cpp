#include <cstddef>

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
static_assert(sizeof(softcd_point) == sizeof(QueryPoint) &&
              offsetof(softcd_point, max_distance) == offsetof(QueryPoint, max_distance));
static_assert(sizeof(softcd_closest_point) == sizeof(ClosestPoint) &&
              offsetof(softcd_closest_point, triangle) == offsetof(ClosestPoint, triangle) &&
              offsetof(softcd_closest_point, position) == offsetof(ClosestPoint, position) &&
              offsetof(softcd_closest_point, distance) == offsetof(ClosestPoint, distance) &&
              offsetof(softcd_closest_point, weights) == offsetof(ClosestPoint, weights) &&
              offsetof(softcd_closest_point, side) == offsetof(ClosestPoint, side));
static_assert(sizeof(softcd_sphere) == sizeof(QuerySphere) &&
              offsetof(softcd_sphere, radius) == offsetof(QuerySphere, radius));
static_assert(sizeof(softcd_box) == sizeof(QueryBox) && offsetof(softcd_box, hi) == offsetof(QueryBox, hi));
static_assert(sizeof(softcd_oriented_box) == sizeof(QueryOrientedBox) &&
              offsetof(softcd_oriented_box, half) == offsetof(QueryOrientedBox, half) &&
              offsetof(softcd_oriented_box, axes) == offsetof(QueryOrientedBox, axes));
static_assert(sizeof(softcd_overlap) == sizeof(TriangleOverlap) &&
              offsetof(softcd_overlap, triangle) == offsetof(TriangleOverlap, triangle));

/// Asks one answer for each question, or lists of them, by `ask(probe)`.
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
    return asked.closest_points(c::elements<softcd::QueryPoint>(points, count, "points"));
  });
}

softcd_status softcd_probe_sphere_overlaps(softcd_probe* probe, const softcd_sphere* spheres, uint64_t count,
                                           const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::QuerySphere>(spheres, count, "spheres"));
  });
}

softcd_status softcd_probe_box_overlaps(softcd_probe* probe, const softcd_box* boxes, uint64_t count,
                                        const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::QueryBox>(boxes, count, "boxes"));
  });
}

softcd_status softcd_probe_oriented_box_overlaps(softcd_probe* probe, const softcd_oriented_box* boxes, uint64_t count,
                                                 const uint64_t** begins, const softcd_overlap** overlaps) {
  return c::ask_lists(probe, begins, overlaps, [&](softcd::Probe& asked) {
    return asked.overlaps(c::elements<softcd::QueryOrientedBox>(boxes, count, "boxes"));
  });
}
