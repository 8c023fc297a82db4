#pragma once

#include "softcd/core/vec3.hpp"

namespace softcd::test {

/// Compute distances in long double as the minimum over all pairs of sub-features. They are slow, simple, and correct
/// for degenerate triangles and parallel edges: interiors of these are skipped, and their boundaries give the result.
long double distance_point_segment(Vec3d p, Vec3d a, Vec3d b);
long double distance_vertex_triangle(Vec3d v, Vec3d f0, Vec3d f1, Vec3d f2);
long double distance_edge_edge(Vec3d e0, Vec3d e1, Vec3d g0, Vec3d g1);

}  // namespace softcd::test
