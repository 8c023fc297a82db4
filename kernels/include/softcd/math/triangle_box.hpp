#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Whether the triangle's plane, or an axis across one of its sides and one of the box's, has the triangle and the box
/// on two sides: with the boxes' own axes all that can part them (Akenine-Moeller, Fast 3D Triangle-Box Overlap
/// Testing, 2001). Triangles without area are parted by what parts segments and points. What touches is not parted.
/// The triangle is given as seen from the box's centre, along its axes.
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
