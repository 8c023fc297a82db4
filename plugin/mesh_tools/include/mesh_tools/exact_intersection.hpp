#pragma once

#include <array>

#include "softcd/core/vec3.hpp"

namespace softcd::mesh_tools {

/// Returns whether the segment pq and the triangle have a point in common, borders and touching included. Exact for all
/// finite coordinates, also for coplanar features and degenerate triangles and segments.
bool intersects(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle);

/// Returns whether p and q lie on either side of the triangle's plane, and the segment pq passes through the triangle's
/// inside: neither p nor q is in the plane, and pq does not meet the border. As exact as intersects().
bool passes_through(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle);

}  // namespace softcd::mesh_tools
