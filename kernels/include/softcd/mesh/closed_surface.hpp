#pragma once

#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Returns whether the mesh, apart from its segments, is a closed and oriented manifold. It has triangles; every edge
/// has two of them, which pass through it in opposite directions; and the triangles of each vertex surround it once.
bool is_closed_surface(const MeshView& mesh);

}  // namespace softcd
