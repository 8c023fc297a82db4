#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/mesh/scene_view.hpp"

/// The boxes of ContactRule::ahead.
namespace softcd {

/// How far the boxes reach ahead, in motions of the step.
constexpr float kAheadMotion = 3.0F;
/// By how many of their body's margins the boxes are grown.
constexpr float kAheadMargins = 2.0F;
/// Bounds the roundings of a box, of its positions too, relative to the largest coordinate.
constexpr float kAheadError = 4.0F * kCoordinateError;

/// An interval of a box, grown ahead.
struct IntervalAhead {
  float lo, hi;

  static SOFTCD_HD IntervalAhead of(float lo, float hi, float motion) {
    return {lo + smaller(0.0F, motion), hi + larger(0.0F, motion)};
  }
};

/// Returns false only if the box of each of the vertices is apart from the triangle's box. `margins` is the sum of
/// their bodies' margins.
template <int kVertices>
SOFTCD_HD bool may_meet_ahead(const SceneView& scene, const std::uint32_t (&vertices)[kVertices],
                              const Triangle& triangle, float margins) {
  float size = margins;
  const auto measured = [&](Vec3f x) {
    size = larger(size, max_norm(x));
    return x;
  };
  Vec3f t0[kVertices];
  Vec3f t1[kVertices];
  for (int i = 0; i < kVertices; ++i) {
    t0[i] = measured(scene.x_t0[vertices[i]]);
    t1[i] = measured(scene.x_t1[vertices[i]]);
  }
  Vec3f corners_t0[3];
  Vec3f corners_t1[3];
  for (int i = 0; i < 3; ++i) {
    corners_t0[i] = measured(scene.x_t0[triangle.v[i]]);
    corners_t1[i] = measured(scene.x_t1[triangle.v[i]]);
  }
  const float reach = outward_up(kAheadMargins * margins + 2.0F * kAheadError * size);
  bool are_apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = corners_t1[0][axis];
    const float b = corners_t1[1][axis];
    const float c = corners_t1[2][axis];
    // Three times the mean of the three motions.
    const float motion = ((a - corners_t0[0][axis]) + (b - corners_t0[1][axis])) + (c - corners_t0[2][axis]);
    const IntervalAhead face = IntervalAhead::of(smaller(smaller(a, b), c), larger(larger(a, b), c), motion);
    bool is_below = true;
    bool is_above = true;
    for (int i = 0; i < kVertices; ++i) {
      const float x = t1[i][axis];
      const IntervalAhead vertex = IntervalAhead::of(x, x, kAheadMotion * (x - t0[i][axis]));
      is_below = is_below && face.lo - vertex.hi > reach;
      is_above = is_above && vertex.lo - face.hi > reach;
    }
    are_apart |= is_below | is_above;
  }
  return !are_apart;
}

}  // namespace softcd
