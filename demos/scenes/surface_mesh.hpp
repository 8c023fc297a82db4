#pragma once

#include <array>
#include <memory>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::demo {

/// Triangles turn counterclockwise seen from outside.
struct SurfaceMesh {
  std::vector<btVector3> positions;
  std::vector<std::array<int, 3>> triangles;
};

/// 20 * 4^subdivisions triangles.
SurfaceMesh sphere_mesh(const btVector3& center, btScalar radius, int subdivisions);

/// A point of an outline that is turned about the y axis.
struct ProfilePoint {
  btScalar radius;
  btScalar height;
};

/// The surface on the right of the outline: upwards it is the outer side of a solid. An end on the axis is closed by a
/// fan; no other point is on the axis.
SurfaceMesh lathe_mesh(const std::vector<ProfilePoint>& profile, int segments);

/// The outline with points added until none is farther from the next than `spacing`.
std::vector<ProfilePoint> refined(const std::vector<ProfilePoint>& profile, btScalar spacing);

/// A body whose nodes weigh `node_mass` each, with a link along every edge and VF_SS on. With mass 0 all its nodes are
/// fixed: it moves as their velocities say.
std::unique_ptr<btSoftBody> make_body(btSoftBodyWorldInfo& world_info, const SurfaceMesh& mesh, btScalar node_mass);

}  // namespace softcd::demo
