#pragma once

#include <array>

#include "softcd/core/vec3.hpp"

namespace softcd::demo {

/// Whether the segment pq and the triangle have a point in common, borders and touching included, decided exactly for
/// all finite coordinates: coplanar ones, and triangles and segments that are degenerate, too.
bool intersects(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle);

}  // namespace softcd::demo
