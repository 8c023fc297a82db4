#pragma once

#include <cmath>

#include "LinearMath/btVector3.h"
#include "softcd/core/vec3.hpp"

namespace softcd::demo {

inline Vec3d to_vec3d(const btVector3& v) {
  return {double(v.x()), double(v.y()), double(v.z())};
}

/// Returns a vector of length 1 along `v`; upwards where `v` has no direction.
inline Vec3d unit(Vec3d v) {
  const double norm = std::sqrt(squared_norm(v));
  return norm > 0 ? (1 / norm) * v : Vec3d{0, 1, 0};
}

/// The orthonormal frame of a viewer: right, up and towards the viewer.
struct ViewFrame {
  Vec3d right, up, back;
};

/// Returns the frame of a viewer who looks along `direction`, with `right` level. `direction` must not be vertical.
inline ViewFrame looking_along(Vec3d direction) {
  ViewFrame frame{};
  frame.back = -unit(direction);
  frame.right = unit(cross({0, 1, 0}, frame.back));
  frame.up = cross(frame.back, frame.right);
  return frame;
}

}  // namespace softcd::demo
