#pragma once

#include <cstddef>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct MeshView {
  const std::vector<Triangle>& triangles;
  const std::vector<Vec3f>& x;
};

/// Compares every triangle of `a` with every triangle of `b`, with softcd's own tests of two triangles, on all threads:
/// softcd without a broad phase. Returns the smallest distance. Skips triangles whose boxes are further apart than the
/// smallest distance so far.
double distance_by_every_pair(const MeshView& a, const MeshView& b);
/// Returns the number of intersecting pairs.
std::size_t intersections_by_every_pair(const MeshView& a, const MeshView& b);
/// Returns the number of the mesh's triangles that intersect an added one, summed over the added triangles. Does not
/// compare added triangles with each other: in the benchmark each two have an edge in common.
std::size_t intersections_after_by_every_pair(const MeshView& mesh, const ProbeChange& change);

}  // namespace softcd::benchmarks
