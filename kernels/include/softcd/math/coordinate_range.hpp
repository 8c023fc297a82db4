#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Largest usable coordinate. Beyond it the sum of two coordinates might overflow float32, so it counts as not finite.
constexpr double kLargestCoordinate = 1.0e37;

SOFTCD_HD inline bool is_usable(const Vec3d& p) {
  return magnitude(p.x) <= kLargestCoordinate && magnitude(p.y) <= kLargestCoordinate &&
         magnitude(p.z) <= kLargestCoordinate;
}

}  // namespace softcd
