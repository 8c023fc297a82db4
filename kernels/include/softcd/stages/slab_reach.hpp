#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/math/closest_point.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/simd.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/contact_tests.hpp"

/// The boxes of ContactRule::slab. Volumes are grown by sqrt(5) margins, and contacts that far away lie beside a
/// triangle. Along the normal a slab reaches one margin.
namespace softcd {

/// How far contacts with a triangle may lie beyond its box along x, y and z, as shares of what their volumes are grown
/// by. Covers contacts of its edges.
struct alignas(16) SlabReach {
  float share[4];  ///< the last one counts for nothing
};

/// Finds the reach of each triangle that takes part. For scenes that have_certain_slabs().
struct MeasureSlab {
  SceneView scene;
  const Kdop18* volumes;
  SlabReach* reaches;

  SOFTCD_HD void operator()(std::uint32_t t) const {
    if (!is_empty(volumes[t])) reaches[t] = reach_of(load_triangle(scene, t).t1);
  }

  static SOFTCD_HD SlabReach reach_of(const Vec3f (&x)[3]) {
    SlabReach reach{{1.0F, 1.0F, 1.0F, 1.0F}};
    Vec3f b = x[1] - x[0];
    Vec3f c = x[2] - x[0];
    const float scale = safe_scale(larger(max_norm(b), max_norm(c)));
    b = scale * b;
    c = scale * c;
    const Vec3f normal = cross(b, c);
    const float product = max_norm(b) * max_norm(c);
    const float error = kSlabCrossError * product;
    const float twice_area = norm(normal) - error;
    if (!(twice_area > 0.0F && product >= detail::smallest_product<float>())) return reach;
    const float slack = sqrtf(2.0F / twice_area);
    for (int axis = 0; axis < 3; ++axis) {
      const float low = smaller(0.0F, smaller(b[axis], c[axis]));
      const float high = larger(0.0F, larger(b[axis], c[axis]));
      const float margins = slack * (high - low) + (magnitude(normal[axis]) + error) / twice_area;
      reach.share[axis] = smaller(1.0F, kShareOfMargin * larger(1.0F, margins));
    }
    return reach;
  }

 private:
  /// A margin's share of the distance, 1 / sqrt(5), with an allowance for roundings as in certainly_outside_slab().
  static constexpr float kShareOfMargin = 1.0001F / kSlabFactor;
};

namespace generic {
SOFTCD_HD inline bool certainly_beyond_slabs(const Kdop18& a, const Kdop18& b, float growth, const SlabReach& reach_a,
                                             const SlabReach& reach_b) {
  bool is_beyond = false;
  for (int axis = 0; axis < 3; ++axis) {
    const float unreached = growth * (1.0F - larger(reach_a.share[axis], reach_b.share[axis])) - FLT_MIN;
    is_beyond |= smaller(a.hi[axis] - b.lo[axis], b.hi[axis] - a.lo[axis]) < unreached;
  }
  return is_beyond;
}
}  // namespace generic

/// Returns true only if no features of the triangles are in contact, because the two are further apart along x, y or z
/// than the slabs reach. Together, their volumes have been grown by at least `growth`. The allowance in the shares
/// covers the roundings here, and FLT_MIN those of the smallest floats.
SOFTCD_HD inline bool certainly_beyond_slabs(const Kdop18& a, const Kdop18& b, float growth, const SlabReach& reach_a,
                                             const SlabReach& reach_b) {
#ifdef SOFTCD_SSE2
  const __m128 share = _mm_max_ps(_mm_load_ps(reach_a.share), _mm_load_ps(reach_b.share));
  const __m128 unreached =
      _mm_sub_ps(_mm_mul_ps(_mm_set1_ps(growth), _mm_sub_ps(_mm_set1_ps(1.0F), share)), _mm_set1_ps(FLT_MIN));
  const __m128 shared = _mm_min_ps(_mm_sub_ps(_mm_loadu_ps(a.hi), _mm_loadu_ps(b.lo)),
                                   _mm_sub_ps(_mm_loadu_ps(b.hi), _mm_loadu_ps(a.lo)));
  return (_mm_movemask_ps(_mm_cmplt_ps(shared, unreached)) & 7) != 0;
#else
  return generic::certainly_beyond_slabs(a, b, growth, reach_a, reach_b);
#endif
}

}  // namespace softcd
