#pragma once

#include <cstdint>

#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Divides a mesh into patches of at most kPatchSize triangles. They are neighbours on the mesh, so that they stay near
/// each other however it is deformed. Grows patches one beside the other, always by the triangle that shares the most
/// sides with the patch. Puts triangles with few neighbours together in the order of their indices.
PatchOrder patch_order(const MeshView& mesh);

}  // namespace softcd
