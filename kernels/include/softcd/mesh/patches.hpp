#pragma once

#include <cstdint>

#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/topology.hpp"

namespace softcd {

/// Divides a mesh into patches of at most kPatchSize triangles that are neighbours, and stay so however the mesh is
/// deformed. Grows patches one beside the other, always by the triangle that shares the most sides with the patch.
/// Triangles with few neighbours are put together in the order of their indices.
PatchOrder patch_order(const MeshView& mesh);

}  // namespace softcd
