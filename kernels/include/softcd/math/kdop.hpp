#pragma once

#include <cfloat>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/box.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/math/simd.hpp"

namespace softcd {

/// Number of axes of an 18-DOP (Klosowski et al. 1998): x, y, z, x+y, x+z, y+z, x-y, x-z, y-z.
constexpr int kKdopAxes = 9;

/// Intervals of a point set along the nine axes. The diagonal axes are not normalised: their unit is sqrt(2) times
/// shorter than the coordinates' unit. Aligned for copies of 16 bytes.
struct alignas(16) Kdop18 {
  float lo[kKdopAxes];
  float hi[kKdopAxes];
};

/// Returns a volume that contains nothing and overlaps nothing. Extended by a point, it becomes that point's volume.
SOFTCD_HD constexpr Kdop18 empty_kdop() {
  Kdop18 dop{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = FLT_MAX;
    dop.hi[axis] = -FLT_MAX;
  }
  return dop;
}

SOFTCD_HD constexpr bool is_empty(const Kdop18& dop) {
  return dop.hi[0] < dop.lo[0];
}

/// Extends the volume by a point. Each projection is rounded once and hence monotone: volumes of touching points
/// overlap without padding.
SOFTCD_HD inline void extend(Kdop18& dop, Vec3f p) {
  const float projection[kKdopAxes] = {p.x, p.y, p.z, p.x + p.y, p.x + p.z, p.y + p.z, p.x - p.y, p.x - p.z, p.y - p.z};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = smaller(dop.lo[axis], projection[axis]);
    dop.hi[axis] = larger(dop.hi[axis], projection[axis]);
  }
}

namespace generic {
SOFTCD_HD inline Kdop18 merged(const Kdop18& a, const Kdop18& b) {
  Kdop18 both{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    both.lo[axis] = smaller(a.lo[axis], b.lo[axis]);
    both.hi[axis] = larger(a.hi[axis], b.hi[axis]);
  }
  return both;
}
}  // namespace generic

/// Returns the volume that contains both.
SOFTCD_HD inline Kdop18 merged(const Kdop18& a, const Kdop18& b) {
#ifdef SOFTCD_SSE2
  Kdop18 both;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  const auto merge_four = [&](int axis) {
    _mm_storeu_ps(both.lo + axis, _mm_min_ps(_mm_loadu_ps(a.lo + axis), _mm_loadu_ps(b.lo + axis)));
    _mm_storeu_ps(both.hi + axis, _mm_max_ps(_mm_loadu_ps(a.hi + axis), _mm_loadu_ps(b.hi + axis)));
  };
  merge_four(0);
  merge_four(4);
  merge_four(5);
  return both;
#else
  return generic::merged(a, b);
#endif
}

SOFTCD_HD inline float furthest_coordinate(const Kdop18& dop) {
  float furthest = 0.0F;
  for (int axis = 0; axis < 3; ++axis) {
    furthest = larger(furthest, larger(magnitude(dop.lo[axis]), magnitude(dop.hi[axis])));
  }
  return furthest;
}

/// A lower bound of a distance along the axes. `diagonal` includes the rounding of projections onto diagonals.
struct AxisDistance {
  float straight, diagonal;
};

SOFTCD_HD constexpr float straight_distance(float distance) {
  return distance > 0.0F ? distance : 0.0F;
}

/// Returns the distance along the axes for points with coordinates up to `furthest`. A distance of 0 needs no slack,
/// because projections are monotone.
SOFTCD_HD inline AxisDistance axis_distance(float distance, float furthest) {
  if (!(distance > 0.0F)) return {0.0F, 0.0F};
  return {distance, outward_up(distance * 1.41421357F) + kCoordinateError * furthest};
}

/// Grows the volume by a ball of radius `radius`, rounded outward. A radius of 0 changes nothing.
SOFTCD_HD inline void inflate(Kdop18& dop, float radius) {
  if (!(radius > 0.0F) || is_empty(dop)) return;
  const AxisDistance distance = axis_distance(radius, furthest_coordinate(dop));
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    const float growth = axis < 3 ? distance.straight : distance.diagonal;
    dop.lo[axis] = outward_down(dop.lo[axis] - growth);
    dop.hi[axis] = outward_up(dop.hi[axis] + growth);
  }
}

/// Returns the volume of a triangle's corners, grown by a ball of this radius. cpu/lanes/volumes.cpp does the same for
/// several triangles at once.
SOFTCD_HD inline Kdop18 grown_volume(const Vec3f (&points)[3], float radius) {
  Kdop18 dop = empty_kdop();
  for (const Vec3f& point : points) extend(dop, point);
  inflate(dop, radius);
  return dop;
}

namespace generic {
/// Returns whether the volumes overlap. They are passed by value so that the device reads them in 16-byte pieces.
SOFTCD_HD inline bool overlap(const Kdop18 a, const Kdop18 b) {
  bool is_apart = false;
  for (int axis = 0; axis < 3; ++axis) is_apart |= (a.hi[axis] < b.lo[axis]) | (b.hi[axis] < a.lo[axis]);
  if (is_apart) return false;
  for (int axis = 3; axis < kKdopAxes; ++axis) is_apart |= (a.hi[axis] < b.lo[axis]) | (b.hi[axis] < a.lo[axis]);
  return !is_apart;
}
}  // namespace generic

SOFTCD_HD inline bool overlap(const Kdop18& a, const Kdop18& b) {
#ifdef SOFTCD_SSE2
  const auto gaps = [&](int axis) {
    const __m128 a_below = _mm_cmplt_ps(_mm_loadu_ps(a.hi + axis), _mm_loadu_ps(b.lo + axis));
    const __m128 b_below = _mm_cmplt_ps(_mm_loadu_ps(b.hi + axis), _mm_loadu_ps(a.lo + axis));
    return _mm_or_ps(a_below, b_below);
  };
  return _mm_movemask_ps(_mm_or_ps(_mm_or_ps(gaps(0), gaps(4)), gaps(5))) == 0;
#else
  return generic::overlap(a, b);
#endif
}

namespace generic {
SOFTCD_HD inline bool contains(const Kdop18& outer, const Kdop18& inner) {
  bool is_within = !is_empty(inner);
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    is_within &= (outer.lo[axis] <= inner.lo[axis]) & (inner.hi[axis] <= outer.hi[axis]);
  }
  return is_within;
}
}  // namespace generic

/// Returns whether `inner` is not empty and lies within `outer`, borders included.
SOFTCD_HD inline bool contains(const Kdop18& outer, const Kdop18& inner) {
#ifdef SOFTCD_SSE2
  const auto within = [&](int axis) {
    const __m128 is_above = _mm_cmple_ps(_mm_loadu_ps(outer.lo + axis), _mm_loadu_ps(inner.lo + axis));
    const __m128 is_below = _mm_cmple_ps(_mm_loadu_ps(inner.hi + axis), _mm_loadu_ps(outer.hi + axis));
    return _mm_and_ps(is_above, is_below);
  };
  return !is_empty(inner) && _mm_movemask_ps(_mm_and_ps(_mm_and_ps(within(0), within(4)), within(5))) == 15;
#else
  return generic::contains(outer, inner);
#endif
}

/// Returns whether two sets of points are certainly more than `distance` apart along x, y or z. Each volume contains a
/// set that was grown by a ball. The balls' radii add up to at least `growth`.
SOFTCD_HD inline bool certainly_apart_before_growth(const Kdop18& a, const Kdop18& b, float growth, float distance) {
  const float excess = outward_down(growth - distance);
  if (!(excess > 0.0F)) return false;
  bool is_apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    is_apart |= outward_up(smaller(a.hi[axis] - b.lo[axis], b.hi[axis] - a.lo[axis])) < excess;
  }
  return is_apart;
}

/// Returns the volume's intervals along x, y and z as a box.
SOFTCD_HD constexpr Box box_of(const Kdop18& dop) {
  return {{dop.lo[0], dop.lo[1], dop.lo[2]}, {dop.hi[0], dop.hi[1], dop.hi[2]}};
}

SOFTCD_HD constexpr bool overlap(const Box& box, const Kdop18& dop) {
  return box.lo.x <= dop.hi[0] && dop.lo[0] <= box.hi.x && box.lo.y <= dop.hi[1] && dop.lo[1] <= box.hi.y &&
         box.lo.z <= dop.hi[2] && dop.lo[2] <= box.hi.z;
}

}  // namespace softcd
