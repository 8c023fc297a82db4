#include "scene_model.hpp"

#include <algorithm>
#include <cmath>

#include "brute_force.hpp"
#include "bytes.hpp"

namespace softcd::test {
namespace {

/// Limits, because exact arithmetic is slow.
constexpr std::size_t kMostTriangles = 60;
constexpr std::size_t kMostMovingTriangles = 20;

constexpr double kLargestCoordinate = 1e37;

/// Returns positions without coordinates that a detector treats as not finite.
Positions3 finite_positions(Positions3 x) {
  for (Vec3d& p : x) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!(std::abs(p[axis]) <= kLargestCoordinate)) p = {NAN, NAN, NAN};
    }
  }
  return x;
}

double extent_of(const Scene& scene) {
  double extent = 0.0;
  for (const SceneBody& body : scene) {
    for (const Positions3* x : {&body.x_t0, &body.x_t1}) {
      for (const Vec3d& p : *x) {
        if (std::isfinite(p.x)) extent = std::max({extent, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      }
    }
  }
  return extent;
}

}  // namespace

softcd::Scene SceneModel::fresh_scene() const {
  SceneOptions options;
  options.backend = Backend::cpu;
  options.max_threads = 1;
  softcd::Scene scene(options);
  for (const Body& body : bodies) {
    const auto vertex_count = static_cast<std::uint32_t>(body.mesh.x_t1.size());
    const BodyId id = scene.add_body({body.mesh.triangles, vertex_count, body.mesh.settings});
    if (body.has_positions) scene.set_positions(id, body.mesh.x_t0, body.mesh.x_t1);
  }
  return scene;
}

std::vector<Contact> SceneModel::fresh_contacts(const QueryOptions& options, const PairFilter& filter) const {
  softcd::Scene scene = fresh_scene();
  Query query(scene, options);
  if (filter) query.set_pair_filter([&](BodyId a, BodyId b) { return filter(bodies[a.value].id, bodies[b.value].id); });
  const Span<const Contact> found = query.detect();
  std::vector<Contact> contacts(found.begin(), found.end());
  for (Contact& contact : contacts) {
    contact.body_a = bodies[contact.body_a.value].id;
    contact.body_b = bodies[contact.body_b.value].id;
  }
  return contacts;
}

std::vector<RayHit> SceneModel::fresh_hits(Span<const Ray> rays, StepEnd end) const {
  softcd::Scene scene = fresh_scene();
  Probe probe(scene, {end});
  const Span<const RayHit> found = probe.first_hits(rays);
  std::vector<RayHit> hits(found.begin(), found.end());
  for (RayHit& hit : hits) {
    if (hit.has_hit()) hit.body = bodies[hit.body.value].id;
  }
  return hits;
}

std::vector<ClosestPoint> SceneModel::fresh_closest_points(Span<const ProbePoint> points, StepEnd end) const {
  softcd::Scene scene = fresh_scene();
  Probe probe(scene, {end});
  const Span<const ClosestPoint> found = probe.closest_points(points);
  std::vector<ClosestPoint> closest(found.begin(), found.end());
  for (ClosestPoint& point : closest) {
    if (point.has_point()) point.body = bodies[point.body.value].id;
  }
  return closest;
}

Scene SceneModel::needed_positions(const QueryOptions& options) const {
  Scene scene;
  for (const Body& body : bodies) {
    if (!body.has_positions) {
      scene.emplace_back();
      continue;
    }
    SceneBody seen = body.mesh;
    seen.x_t0 = finite_positions(seen.x_t0);
    seen.x_t1 = finite_positions(seen.x_t1);
    if (options.detection == Detection::dcd) {
      (options.step_end == StepEnd::t0 ? seen.x_t1 : seen.x_t0) =
          options.step_end == StepEnd::t0 ? seen.x_t0 : seen.x_t1;
    }
    if (!options.margins) seen.settings.margin = 0.0F;
    seen.settings.self_collision = seen.settings.self_collision && !seen.settings.kinematic;
    seen.settings.features.vertex_triangle &= options.features.vertex_triangle;
    seen.settings.features.edge_edge &= options.features.edge_edge;
    scene.push_back(std::move(seen));
  }
  return scene;
}

void SceneModel::require_what_brute_force_finds(const QueryOptions& options, Span<const Contact> contacts) const {
  const bool is_continuous = options.detection == Detection::ccd;
  std::size_t triangles = 0;
  for (const Body& body : bodies) triangles += body.mesh.triangles.size();
  if (triangles > (is_continuous ? kMostMovingTriangles : kMostTriangles)) return;
  if (!is_continuous && (options.contact_rule != ContactRule::distance || options.accuracy == Accuracy::fast ||
                         options.motion_margin > 0.0F)) {
    return;
  }
  const Scene scene = needed_positions(options);
  DiscreteRules rules;
  rules.absolute_band = 1e-12 * extent_of(scene);
  const Verdicts verdicts = is_continuous ? continuous_verdicts(scene) : discrete_verdicts(scene, rules);
  std::vector<FeaturePair> reported = features_of(contacts);
  const auto place_of = [&](std::uint32_t id) {
    const auto body = std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.id.value == id; });
    require(body != bodies.end(), "contacts are those of the scene's bodies");
    return static_cast<std::uint32_t>(body - bodies.begin());
  };
  for (FeaturePair& pair : reported) {
    pair.body_a = place_of(pair.body_a);
    pair.body_b = place_of(pair.body_b);
  }
  const Difference difference = compare(verdicts, reported);
  require(difference.missed.empty() && difference.repeated.empty(), "nothing is lost: " + describe(difference));
  require(is_continuous || difference.extra.empty(), "nothing is made up: " + describe(difference));
}

}  // namespace softcd::test
