#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/vec3.hpp"

namespace softcd::demo {

/// For each node the sum of the normals of its faces, each as long as the face is large.
std::vector<Vec3d> smooth_normals(const btSoftBody& body);

}  // namespace softcd::demo
