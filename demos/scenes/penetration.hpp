#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::demo {

/// Vertices of each body that have an edge which passes through a triangle, of the same body or another, with which
/// it shares no vertex. In double precision, over a uniform grid.
std::vector<std::vector<bool>> find_piercing_vertices(const std::vector<const btSoftBody*>& bodies);

/// Whether the point is inside a closed convex mesh with outward triangles.
bool is_inside_convex(const btSoftBody& convex, const btVector3& point);

}  // namespace softcd::demo
