#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/box.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

struct Sphere {
  Vec3f centre;
  float radius;
};

/// Returns the sphere around the triangle's box; its radius is half the box's diagonal. It needs no division, so
/// slivers and points are no special cases.
SOFTCD_HD inline Sphere bounding_sphere(Vec3f a, Vec3f b, Vec3f c) {
  const Box box = merged(merged(box_of(a), box_of(b)), box_of(c));
  const Vec3f diagonal = box.hi - box.lo;
  return {box.lo + 0.5F * diagonal, outward_up(0.5F * length(diagonal))};
}

}  // namespace softcd
