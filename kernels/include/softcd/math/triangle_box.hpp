#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Returns whether the triangle and the box are separated by the triangle's plane, or along an axis across a triangle's
/// side and a box's side. With the box's own axes, these are all possible separating axes (Akenine-Moeller, Fast 3D
/// Triangle-Box Overlap Testing, 2001). For triangles without area, the axes of segments and points are among them.
/// Touching counts as not separated. The triangle's corners are relative to the box's centre, along the box's axes.
SOFTCD_HD inline bool are_separate_across(const Vec3d (&v)[3], Vec3d half) {
  const auto parts = [&](Vec3d axis) {
    const double reach = half.x * magnitude(axis.x) + half.y * magnitude(axis.y) + half.z * magnitude(axis.z);
    const double a = dot(axis, v[0]);
    const double b = dot(axis, v[1]);
    const double c = dot(axis, v[2]);
    return smaller(smaller(a, b), c) > reach || larger(larger(a, b), c) < -reach;
  };
  if (parts(cross(v[1] - v[0], v[2] - v[0]))) return true;
  for (int side = 0; side < 3; ++side) {
    const Vec3d d = v[side == 2 ? 0 : side + 1] - v[side];
    if (parts({0.0, -d.z, d.y}) || parts({d.z, 0.0, -d.x}) || parts({-d.y, d.x, 0.0})) return true;
  }
  return false;
}

}  // namespace softcd
