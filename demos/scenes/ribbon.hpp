#pragma once

#include <vector>

#include "scenes/cloth.hpp"

namespace softcd::demo {

/// A strip of cloth along the uniform cubic B-spline of the control points, from the first to the last of them, with
/// cells as long as they are wide. Columns run along it and rows across. The strip stands upright wherever the curve
/// is level, so that curves in a horizontal plane bend it without stretching it.
ClothShape ribbon_shape(const std::vector<btVector3>& control_points, btScalar width, int columns);

/// An elastic ribbon that collides with itself.
std::unique_ptr<btSoftBody> make_ribbon(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar friction);

/// How much longer than in the beginning the part between two columns of a ribbon is, in a straight line, as a share
/// of its length in the beginning. Negative where it hangs loose.
class StretchGauge {
 public:
  StretchGauge(const btSoftBody& ribbon, int columns, int from_column, int to_column);
  btScalar stretch() const;

 private:
  const btSoftBody* ribbon_;
  int from_node_, to_node_;
  btScalar length_ = 0;
};

/// Of a hand that pulls at a ribbon: it starts gently, and stops where the ribbon is taut.
btScalar hand_speed(btScalar fastest, btScalar stretch, btScalar time);

}  // namespace softcd::demo
