#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"
#include "scene.hpp"
#include "scene_parts.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using LongVec3 = Vec3<long double>;

/// Bodies in a softcd::Scene and a probe on them.
struct ProbedBodies {
  explicit ProbedBodies(Scene its_bodies, StepEnd step_end = StepEnd::t1) : bodies(std::move(its_bodies)) {
    ProbeOptions options;
    options.step_end = step_end;
    probe.set_options(options);
    for (const SceneBody& body : bodies) {
      ids.push_back(scene.add_body(desc_of(body)));
      scene.set_positions(ids.back(), body.x_t0, body.x_t1);
    }
  }

  Scene bodies;
  softcd::Scene scene{scene_options()};
  Probe probe{scene};
  std::vector<BodyId> ids;
};

/// A triangle of a body, with its positions.
struct PlacedTriangle {
  BodyId body;
  std::uint32_t index;
  Vec3d x[3];
};

/// All triangles at one end of the step.
inline std::vector<PlacedTriangle> placed_triangles(const ProbedBodies& probed, StepEnd step_end = StepEnd::t1) {
  std::vector<PlacedTriangle> triangles;
  for (std::size_t b = 0; b < probed.bodies.size(); ++b) {
    const SceneBody& body = probed.bodies[b];
    const Positions3& x = step_end == StepEnd::t1 ? body.x_t1 : body.x_t0;
    for (std::uint32_t t = 0; t < body.triangles.size(); ++t) {
      const auto& v = body.triangles[t].v;
      triangles.push_back({probed.ids[b], t, {x[v[0]], x[v[1]], x[v[2]]}});
    }
  }
  return triangles;
}

/// Scenes with unusual triangles, by name. They are on a grid: positions are the scene's to the last bit.
struct NamedScene {
  std::string name;
  Scene bodies;
};

inline Mesh one_triangle() {
  return {{{{0, 1, 2}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}}};
}

/// The same triangle again and again.
inline Mesh identical_triangles(std::uint32_t count) {
  Mesh mesh = one_triangle();
  mesh.triangles.assign(count, mesh.triangles[0]);
  return mesh;
}

inline Mesh soup_with_everything(std::uint64_t seed, double half_extent = 2.0) {
  SoupOptions options;
  options.triangle_count = 300;
  options.half_extent = half_extent;
  options.size_ratio = 50.0;
  options.needle_share = 0.2;
  options.degenerate_share = 0.2;
  options.joined_share = 0.4;
  options.seed = seed;
  return triangle_soup(options);
}

inline std::vector<NamedScene> odd_scenes() {
  const Mesh soup = soup_with_everything(1);
  const Mesh sheet = grid_cloth(9, 7, 0.25);
  return {{"soups", {still(soup, {}), still(soup_with_everything(2), {})}},
          {"one triangle", {still(one_triangle(), {})}},
          {"identical triangles", {still(identical_triangles(100), {})}},
          {"coincident sheets", {still(sheet, {}), still(sheet, {}), still(moved(sheet, {0, 0, 0.25}), {})}},
          {"one point", {still({{{{0, 0, 0}}, {{0, 1, 0}}}, {{1, 2, 3}, {1, 2, 3}}}, {})}},
          {"huge", {still(scaled(soup, 0x1p100), {})}},
          {"tiny", {still(scaled(soup, 0x1p-100), {})}},
          {"a stray vertex", {still(soup, {}), still(moved(one_triangle(), {4096, 0, 0}), {})}}};
}

/// A triangulated ball whose triangles' normals point outwards, on a grid.
inline Mesh outward_ball(int level, double radius) {
  Mesh mesh = icosphere(level, radius);
  snap_to_grid(mesh.positions, 17);
  for (Triangle& t : mesh.triangles) {
    const Vec3d a = mesh.positions[t.v[0]];
    const Vec3d across = cross(mesh.positions[t.v[1]] - a, mesh.positions[t.v[2]] - a);
    if (dot(across, a) < 0) std::swap(t.v[1], t.v[2]);
  }
  return mesh;
}

/// The largest coordinate.
inline double extent_of(const Scene& bodies) {
  double extent = 0;
  for (const SceneBody& body : bodies) {
    for (const Vec3d& x : body.x_t1) extent = std::max({extent, std::abs(x.x), std::abs(x.y), std::abs(x.z)});
  }
  return extent;
}

}  // namespace softcd::test
