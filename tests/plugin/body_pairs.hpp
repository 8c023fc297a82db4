#pragma once

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "mesh_tools/exact_intersection.hpp"
#include "probing.hpp"
#include "softcd/mesh/features.hpp"

/// Finds intersecting triangles by a rational segment-triangle test that shares no code with the detector.
namespace softcd::test {

using TriangleCorners = std::array<Vec3d, 3>;

/// Returns whether some side of a that has no vertex of b meets b.
inline bool has_side_through(const TriangleCorners& a, const Triangle& vertices_a, const TriangleCorners& b,
                             const Triangle& vertices_b, bool are_of_one_mesh) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    if (are_of_one_mesh && (has_vertex(vertices_b, vertices_a.v[i]) || has_vertex(vertices_b, vertices_a.v[next]))) {
      continue;
    }
    if (mesh_tools::intersects(a[i], a[next], b)) return true;
  }
  return false;
}

inline bool may_meet(const TriangleCorners& a, const TriangleCorners& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto [a_lo, a_hi] = std::minmax({a[0][axis], a[1][axis], a[2][axis]});
    const auto [b_lo, b_hi] = std::minmax({b[0][axis], b[1][axis], b[2][axis]});
    if (a_lo > b_hi || b_lo > a_hi) return false;
  }
  return true;
}

inline bool intersect_exactly(const TriangleCorners& a, const Triangle& vertices_a, const TriangleCorners& b,
                              const Triangle& vertices_b, bool are_of_one_mesh) {
  return may_meet(a, b) && (has_side_through(a, vertices_a, b, vertices_b, are_of_one_mesh) ||
                            has_side_through(b, vertices_b, a, vertices_a, are_of_one_mesh));
}

inline TriangleCorners corners_of(const PlacedTriangle& triangle) {
  return {triangle.x[0], triangle.x[1], triangle.x[2]};
}

/// Body, triangle, body, triangle.
using Intersection = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>;

inline std::vector<Intersection> as_tuples(Span<const TriangleIntersection> found) {
  std::vector<Intersection> tuples;
  for (const TriangleIntersection& pair : found) {
    tuples.emplace_back(pair.body_a.value, pair.triangle_a, pair.body_b.value, pair.triangle_b);
  }
  return tuples;
}

/// Returns all intersections of the scene, each once; bodies are numbered by their places in it.
inline std::vector<Intersection> all_intersections(const ProbedBodies& probed, StepEnd step_end = StepEnd::t1) {
  const std::vector<PlacedTriangle> triangles = placed_triangles(probed, step_end);
  const auto vertices = [&](const PlacedTriangle& t) { return probed.bodies[t.body.value].triangles[t.index]; };
  std::vector<Intersection> pairs;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t j = i + 1; j < triangles.size(); ++j) {
      const PlacedTriangle& a = triangles[i];
      const PlacedTriangle& b = triangles[j];
      if (intersect_exactly(corners_of(a), vertices(a), corners_of(b), vertices(b), a.body == b.body)) {
        pairs.emplace_back(a.body.value, a.index, b.body.value, b.index);
      }
    }
  }
  return pairs;
}

}  // namespace softcd::test
