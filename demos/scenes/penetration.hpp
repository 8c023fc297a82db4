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

/// Finds edges that have a point in common with a triangle, of the same body or another, that contains neither of their
/// vertices. Exact for the nodes' positions, touching included. Compares all pairs that are near each other on a
/// uniform grid. `counts` receives the bodies of an intersecting edge and triangle, and returns whether the
/// intersection counts; without it all count.
using IntersectionFilter = std::function<bool(const btSoftBody& edges, const btSoftBody& triangles)>;
Intersections find_intersections(const std::vector<const btSoftBody*>& bodies,
                                 const IntersectionFilter& counts = nullptr);

/// Returns whether the point is inside a closed mesh, by the winding number.
bool is_inside(const btSoftBody& closed, const btVector3& point);

/// Marks the body's vertices that are inside.
void mark_inside(const btSoftBody& closed, const btSoftBody& body, std::vector<bool>& marked);

/// Marks the body's vertices that are vertically below one of the sheet's triangles.
void mark_below(const btSoftBody& sheet, const btSoftBody& body, std::vector<bool>& marked);

}  // namespace softcd::demo
