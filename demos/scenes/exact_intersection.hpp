#pragma once

#include <array>

#include "softcd/core/vec3.hpp"

namespace softcd::demo {

/// Returns whether the segment pq and the triangle have a point in common, borders and touching included. Exact for all
/// finite coordinates, also for coplanar features and degenerate triangles and segments.
bool intersects(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle);

}  // namespace softcd::demo
