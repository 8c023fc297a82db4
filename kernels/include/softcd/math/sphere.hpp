#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/box.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

struct Sphere {
  Vec3f centre;
  float radius;
};

/// Half the diagonal of the triangle's box: the radius of a sphere around the box's centre that holds the triangle.
/// Needs no division, so slivers and points are as good as any triangle.
SOFTCD_HD inline Sphere bounding_sphere(Vec3f a, Vec3f b, Vec3f c) {
  const Box box = merged(merged(box_of(a), box_of(b)), box_of(c));
  const Vec3f diagonal = box.hi - box.lo;
  return {box.lo + 0.5F * diagonal, outward_up(0.5F * length(diagonal))};
}

}  // namespace softcd
