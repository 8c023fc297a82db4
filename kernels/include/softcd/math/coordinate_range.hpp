#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Beyond this, sums of two coordinates might overflow float32: coordinates count as not finite there.
constexpr double kLargestCoordinate = 1.0e37;

SOFTCD_HD inline bool is_usable(const Vec3d& p) {
  return magnitude(p.x) <= kLargestCoordinate && magnitude(p.y) <= kLargestCoordinate &&
         magnitude(p.z) <= kLargestCoordinate;
}

}  // namespace softcd
