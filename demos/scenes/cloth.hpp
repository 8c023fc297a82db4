#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::demo {

/// A rectangular cloth: columns x rows nodes in row-major order, two triangles per cell with alternating diagonals.
struct ClothShape {
  int columns = 2;
  int rows = 2;
  bool is_closed = false;  ///< the last column is joined to the first, as in a tube; their number is then even
  bool resists_bending = true;
  std::function<btVector3(int column, int row)> position;
  std::function<bool(int column, int row)> is_fixed;  ///< empty: no node is
};

/// Links along the edges and across the diagonals, and where it resists bending over two cells each way. Vertex-face
/// collisions (VF_SS) and rigid ones (SDF_RS) on; kilograms in all.
std::unique_ptr<btSoftBody> make_cloth(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar mass);

/// A flat cloth in the plane y = height, centred on the y axis, `side` long, with side / spacing cells each way.
ClothShape horizontal_cloth(int nodes_per_side, btScalar side, btScalar height);

/// A closed cloth around the vertical axis through `foot`, with columns nodes around it and rows nodes along it,
/// upwards. The faces' fronts are outside.
ClothShape vertical_tube(const btVector3& foot, btScalar radius, btScalar height, int columns, int rows);

/// A sphere of 20 * 4^subdivisions triangles whose nodes are all fixed: it moves as its nodes' velocities say.
std::unique_ptr<btSoftBody> make_ball(btSoftBodyWorldInfo& world_info, const btVector3& center, btScalar radius,
                                      int subdivisions);

}  // namespace softcd::demo
