#pragma once

#include <vector>

#include "scenes/cloth.hpp"

namespace softcd::demo {

/// Returns a strip of cloth along the uniform cubic B-spline of the control points, from the first to the last of them,
/// with square cells. Columns run along it and rows across. The strip stands upright wherever the curve is level, so
/// that curves in a horizontal plane bend it without stretching it.
ClothShape ribbon_shape(const std::vector<btVector3>& control_points, btScalar width, int columns);

/// Makes an elastic ribbon that collides with itself.
std::unique_ptr<btSoftBody> make_ribbon(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar friction);

/// Measures the straight distance between two columns of a ribbon, relative to the beginning: its increase as a share
/// of the initial length. Negative where the ribbon hangs loose.
class StretchGauge {
 public:
  StretchGauge(const btSoftBody& ribbon, int columns, int from_column, int to_column);
  btScalar stretch() const;

 private:
  const btSoftBody* ribbon_;
  int from_node_, to_node_;
  btScalar length_ = 0;
};

/// Returns the speed of a hand that pulls at a ribbon: it starts gently, and stops when the ribbon is taut.
btScalar hand_speed(btScalar fastest, btScalar stretch, btScalar time);

}  // namespace softcd::demo
