#pragma once

#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Whether the mesh, segments apart, is a closed and oriented manifold: there are triangles, every edge has two of
/// them, which pass through it in opposite directions, and those of each vertex surround it once.
bool is_closed_surface(const MeshView& mesh);

}  // namespace softcd
