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

/// A hollow ball that stays about round: its shape is matched in the classic world, its opposite nodes are linked in
/// the deformable one.
std::unique_ptr<btSoftBody> make_soft_ball(SoftWorld& world, const SoftBallShape& shape);

}  // namespace softcd::demo
