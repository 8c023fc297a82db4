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

/// Makes a cloth with links along the edges and across the diagonals, and, if it resists bending, over two cells in
/// each direction. Turns on vertex-face collisions (VF_SS) and rigid ones (SDF_RS). `mass` is the total in kilograms.
std::unique_ptr<btSoftBody> make_cloth(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar mass);

/// Returns a flat cloth in the plane y = height, centred on the y axis. It is `side` long, with side / spacing cells in
/// each direction.
ClothShape horizontal_cloth(int nodes_per_side, btScalar side, btScalar height);

/// Returns a closed cloth around the vertical axis through `foot`, with `columns` nodes around it and `rows` nodes
/// along it, upwards. The faces' fronts are outside.
ClothShape vertical_tube(const btVector3& foot, btScalar radius, btScalar height, int columns, int rows);

/// Makes a sphere of 20 * 4^subdivisions triangles. All its nodes are fixed, so it moves only by its nodes' velocities.
std::unique_ptr<btSoftBody> make_ball(btSoftBodyWorldInfo& world_info, const btVector3& center, btScalar radius,
                                      int subdivisions);

}  // namespace softcd::demo
