#pragma once

#include <cmath>
#include <cstdint>

#include "softcd/math/kdop.hpp"
#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// Corner weights of child `child` of 4^level after `level` Loop 1-to-4 splits (Wong, Leach, Zambetta 2012,
/// section 3.2), in closed form: no recursion. The subdivided triangle has 2^level rows between v[0] and the side
/// v[1]v[2]; row r holds 2 r + 1 children, which alternate between upright and inverted. Weights are multiples of
/// 2^-level, hence exact.
struct ChildWeights {
  /// corner c = (1 - row[c]) v0 + (row[c] - along[c]) v1 + along[c] v2
  float row[3];
  float along[3];
};

struct ChildPlace {
  std::uint32_t row;    ///< row r begins with child r^2
  std::uint32_t place;  ///< in the row; even ones are upright
};

SOFTCD_HD inline ChildPlace child_place(std::uint32_t child) {
  auto row = static_cast<std::uint32_t>(sqrtf(static_cast<float>(child)));
  while (row * row > child) --row;
  while ((row + 1) * (row + 1) <= child) ++row;
  return {row, child - row * row};
}

SOFTCD_HD inline ChildWeights child_weights(int level, std::uint32_t child) {
  const ChildPlace at = child_place(child);
  const std::uint32_t column = at.place / 2;
  const float step = 1.0F / static_cast<float>(1U << level);
  const float upper = step * static_cast<float>(at.row);
  const float lower = step * static_cast<float>(at.row + 1);
  const float left = step * static_cast<float>(column);
  const float right = step * static_cast<float>(column + 1);
  if (at.place % 2 == 0) return {{upper, lower, lower}, {left, left, right}};
  return {{upper, upper, lower}, {left, right, right}};
}

SOFTCD_HD inline Vec3f child_corner(const ChildWeights& weights, int corner, const Vec3f (&v)[3]) {
  return v[0] + (weights.row[corner] * (v[1] - v[0]) + weights.along[corner] * (v[2] - v[1]));
}

/// Returns the part of a triangle's motion that child `child` follows.
SOFTCD_HD inline TriangleMotion child_motion(const TriangleMotion& parent, int level, std::uint32_t child) {
  const ChildWeights weights = child_weights(level, child);
  TriangleMotion motion{};
  for (int corner = 0; corner < 3; ++corner) {
    motion.t0[corner] = child_corner(weights, corner, parent.t0);
    motion.t1[corner] = child_corner(weights, corner, parent.t1);
  }
  return motion;
}

/// Returns the 18-DOP of a child over the whole step, inflated by `growth` and by what rounding may have moved its
/// corners.
SOFTCD_HD inline Kdop18 child_volume(const TriangleMotion& parent, int level, std::uint32_t child, float growth) {
  const TriangleMotion motion = child_motion(parent, level, child);
  Kdop18 volume = empty_kdop();
  float furthest = 0.0F;
  for (int corner = 0; corner < 3; ++corner) {
    extend(volume, motion.t0[corner]);
    extend(volume, motion.t1[corner]);
    furthest = larger(furthest, larger(max_norm(parent.t0[corner]), max_norm(parent.t1[corner])));
  }
  inflate(volume, outward_up(growth + kCoordinateError * furthest));
  return volume;
}

}  // namespace softcd
