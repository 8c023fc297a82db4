#pragma once

#include <array>
#include <memory>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::demo {

/// A mesh whose triangles turn counterclockwise seen from outside.
struct SurfaceMesh {
  std::vector<btVector3> positions;
  std::vector<std::array<int, 3>> triangles;
};

/// Returns a sphere of 20 * 4^subdivisions triangles.
SurfaceMesh sphere_mesh(const btVector3& center, btScalar radius, int subdivisions);

/// A point of an outline that is turned about the y axis.
struct ProfilePoint {
  btScalar radius;
  btScalar height;
};

/// Returns the surface of revolution on the right of the outline: an upward outline gives the outer side of a solid. A
/// fan closes an end on the axis; no other point may be on the axis.
SurfaceMesh lathe_mesh(const std::vector<ProfilePoint>& profile, int segments);

/// Returns the outline with points added until neighbours are at most `spacing` apart.
std::vector<ProfilePoint> refined(const std::vector<ProfilePoint>& profile, btScalar spacing);

/// Makes a body whose nodes weigh `node_mass` each, with a link along every edge and VF_SS on. With mass 0 all its
/// nodes are fixed: it moves only by their velocities.
std::unique_ptr<btSoftBody> make_body(btSoftBodyWorldInfo& world_info, const SurfaceMesh& mesh, btScalar node_mass);

}  // namespace softcd::demo
