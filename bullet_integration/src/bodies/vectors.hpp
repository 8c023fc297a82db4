#pragma once

#include "LinearMath/btVector3.h"
#include "softcd/core/types.hpp"

namespace softcd::bullet {

inline btVector3 to_bullet(Vec3f v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}
inline btVector3 to_bullet(Vec3d v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

inline Vec3d to_doubles(const btVector3& v) {
  return {double(v.x()), double(v.y()), double(v.z())};
}

/// Returns the weights of the triangle's vertices in a vertex-triangle contact.
inline btVector3 triangle_weights(const float (&weights)[4]) {
  return {btScalar(weights[1]), btScalar(weights[2]), btScalar(weights[3])};
}

}  // namespace softcd::bullet
