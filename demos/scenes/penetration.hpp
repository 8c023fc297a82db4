#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::demo {

struct Intersections {
  std::vector<std::vector<bool>> vertices;  ///< of each body: whether one of the vertex's edges is counted
  std::size_t edge_count = 0;
};

/// Edges that have a point in common with a triangle, of the same body or another, to which neither of their vertices
/// belongs. Exact for the nodes' positions as they are, touching included. Looks at every pair that is near on a
/// uniform grid. `counts` is asked about the bodies of an edge and of a triangle that intersect; without it all count.
using IntersectionFilter = std::function<bool(const btSoftBody& edges, const btSoftBody& triangles)>;
Intersections find_intersections(const std::vector<const btSoftBody*>& bodies,
                                 const IntersectionFilter& counts = nullptr);

/// Whether the point is inside a closed mesh, by the winding number.
bool is_inside(const btSoftBody& closed, const btVector3& point);

/// Marks the body's vertices that are inside.
void mark_inside(const btSoftBody& closed, const btSoftBody& body, std::vector<bool>& marked);

/// Marks the body's vertices that are vertically below one of the sheet's triangles.
void mark_below(const btSoftBody& sheet, const btSoftBody& body, std::vector<bool>& marked);

}  // namespace softcd::demo
