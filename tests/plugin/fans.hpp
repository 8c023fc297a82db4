#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "mesh_generators.hpp"
#include "random.hpp"

namespace softcd::test {

/// Returns triangles around vertex 0, too many to be listed, with a rim of x(t), 0 <= t <= 1.
template <class Rim>
Mesh fan(std::uint32_t count, Vec3d hub, const Rim& x) {
  Mesh mesh{{}, {hub, x(0.0)}};
  for (std::uint32_t i = 1; i <= count; ++i) {
    mesh.positions.push_back(x(double(i) / count));
    mesh.triangles.push_back({{0, i, i + 1}});
  }
  snap_to_grid(mesh.positions, 20);
  return mesh;
}

inline Vec3d on_circle(double t, double z) {
  return {std::cos(2 * std::numbers::pi * t), std::sin(2 * std::numbers::pi * t), z};
}

struct NamedFan {
  const char* name;
  Mesh mesh;
};

/// Returns several fans. The star's triangles usually cross each other; the others' do not.
inline std::vector<NamedFan> fans(std::uint32_t count) {
  Random random(count);
  // Part of the circle between the hub, which is a corner of the polygon, and the next corner.
  const double turn = 0.9 / count;
  return {
      {"disc", fan(count, {0, 0, 0}, [](double t) { return on_circle(t, 0); })},
      {"polygon", fan(count, on_circle(0, 0), [&](double t) { return on_circle(turn + t * (1 - 2 * turn), 0); })},
      {"cone", fan(count, {0, 0, 2}, [](double t) { return on_circle(t, 0); })},
      {"needle", fan(count, {0, 0, 2}, [](double t) { return 0.01 * on_circle(t, 0); })},
      {"wavy", fan(count, {0, 0, 0}, [](double t) { return on_circle(t, 0.1 * std::sin(40 * std::numbers::pi * t)); })},
      {"rough", fan(count, {0, 0, 0}, [&](double t) { return on_circle(t, random.uniform(-0.1, 0.1)); })},
      {"wound", fan(count, {0, 0, 0}, [](double t) { return on_circle(3 * t, 0.3 * t * std::sin(9 * t)); })},
      {"star", fan(count, {0, 0, 0}, [&](double) { return random.direction(); })}};
}

}  // namespace softcd::test
