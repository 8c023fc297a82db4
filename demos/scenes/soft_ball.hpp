#pragma once

#include <memory>

#include "scenes/soft_world.hpp"

namespace softcd::demo {

struct SoftBallShape {
  btVector3 center;
  btScalar radius;
  int subdivisions;  ///< 20 * 4^subdivisions triangles
  btScalar mass;     ///< in the classic world
  btScalar margin;
};

/// Makes a hollow ball that stays about round. In the classic world its shape is matched; in the deformable one its
/// opposite nodes are linked.
std::unique_ptr<btSoftBody> make_soft_ball(btSoftBodyWorldInfo& world_info, World kind, const SoftBallShape& shape);
inline std::unique_ptr<btSoftBody> make_soft_ball(SoftWorld& world, const SoftBallShape& shape) {
  return make_soft_ball(world.world_info(), world.kind(), shape);
}

}  // namespace softcd::demo
