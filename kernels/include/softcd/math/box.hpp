#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// An axis-aligned box.
struct Box {
  Vec3f lo, hi;
};

SOFTCD_HD constexpr Box box_of(Vec3f p) {
  return {p, p};
}

SOFTCD_HD constexpr Box merged(const Box& a, const Box& b) {
  return {{smaller(a.lo.x, b.lo.x), smaller(a.lo.y, b.lo.y), smaller(a.lo.z, b.lo.z)},
          {larger(a.hi.x, b.hi.x), larger(a.hi.y, b.hi.y), larger(a.hi.z, b.hi.z)}};
}

SOFTCD_HD inline Box inflated(const Box& box, float radius) {
  if (!(radius > 0.0F)) return box;
  return {{outward_down(box.lo.x - radius), outward_down(box.lo.y - radius), outward_down(box.lo.z - radius)},
          {outward_up(box.hi.x + radius), outward_up(box.hi.y + radius), outward_up(box.hi.z + radius)}};
}

/// Returns whether `inner` lies within `outer`, borders included.
SOFTCD_HD constexpr bool contains(const Box& outer, const Box& inner) {
  return outer.lo.x <= inner.lo.x && inner.hi.x <= outer.hi.x && outer.lo.y <= inner.lo.y && inner.hi.y <= outer.hi.y &&
         outer.lo.z <= inner.lo.z && inner.hi.z <= outer.hi.z;
}

/// Returns whether the boxes overlap. It makes all comparisons: tested boxes overlap so often that one branch is
/// cheaper than six.
SOFTCD_HD constexpr bool overlap(const Box& a, const Box& b) {
  return (a.lo.x <= b.hi.x) & (b.lo.x <= a.hi.x) & (a.lo.y <= b.hi.y) & (b.lo.y <= a.hi.y) & (a.lo.z <= b.hi.z) &
         (b.lo.z <= a.hi.z);
}

}  // namespace softcd
