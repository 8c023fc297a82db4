#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/vec3.hpp"

namespace softcd::demo {

/// Returns for each node the sum of its faces' normals, weighted by the faces' areas.
std::vector<Vec3d> smooth_normals(const btSoftBody& body);

}  // namespace softcd::demo
