#pragma once

#include <cstddef>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct MeshView {
  const std::vector<Triangle>& triangles;
  const std::vector<Vec3f>& x;
};

/// Every triangle of `a` with every one of `b`, by softcd's own tests of two triangles, on all threads: what remains of
/// softcd without anything that finds pairs. The smallest distance of two triangles; those whose boxes are further
/// apart than others are known to be are passed over.
double distance_by_every_pair(const MeshView& a, const MeshView& b);
/// How many of the pairs intersect.
std::size_t intersections_by_every_pair(const MeshView& a, const MeshView& b);
/// How many of the mesh's triangles would intersect an added one, counted for each of these. Added triangles are not
/// compared with each other: those of the benchmark have an edge in common each two.
std::size_t intersections_after_by_every_pair(const MeshView& mesh, const ProbeChange& change);

}  // namespace softcd::benchmarks
