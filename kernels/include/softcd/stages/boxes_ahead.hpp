#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/math/box.hpp"
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

/// The box of some vertices, or of a triangle, without its body's margin.
struct BoxAhead {
  Box box;
  float size;  ///< the largest magnitude of a coordinate at both ends of the step
};

/// Returns a box around vertices at t1 and where each of them is three steps ahead.
template <int kVertices>
SOFTCD_HD BoxAhead vertices_ahead(const SceneView& scene, const std::uint32_t (&vertices)[kVertices]) {
  BoxAhead ahead = {box_of(scene.x_t1[vertices[0]]), 0.0F};
  for (const std::uint32_t v : vertices) {
    const Vec3f t0 = scene.x_t0[v];
    const Vec3f t1 = scene.x_t1[v];
    ahead.size = larger(ahead.size, larger(max_norm(t0), max_norm(t1)));
    ahead.box = merged(ahead.box, merged(box_of(t1), box_of(t1 + kAheadMotion * (t1 - t0))));
  }
  return ahead;
}

/// Returns a box around a triangle at t1 and where it is three steps ahead with the mean motion of its corners.
SOFTCD_HD inline BoxAhead triangle_ahead(const SceneView& scene, const Triangle& triangle) {
  BoxAhead ahead = {box_of(scene.x_t1[triangle.v[0]]), 0.0F};
  Vec3f motion = {0.0F, 0.0F, 0.0F};  // three times the mean
  for (const std::uint32_t v : triangle.v) {
    const Vec3f t0 = scene.x_t0[v];
    const Vec3f t1 = scene.x_t1[v];
    ahead.size = larger(ahead.size, larger(max_norm(t0), max_norm(t1)));
    ahead.box = merged(ahead.box, box_of(t1));
    motion = motion + (t1 - t0);
  }
  ahead.box = merged(ahead.box, Box{ahead.box.lo + motion, ahead.box.hi + motion});
  return ahead;
}

/// Returns false only if the boxes, grown by the rule, are certainly apart. `margins` is the sum of both bodies'
/// margins.
SOFTCD_HD inline bool may_meet(const BoxAhead& a, const BoxAhead& b, float margins) {
  const float reach =
      outward_up(kAheadMargins * margins + 2.0F * kAheadError * larger(margins, larger(a.size, b.size)));
  bool are_apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    are_apart |= (a.box.lo[axis] - b.box.hi[axis] > reach) | (b.box.lo[axis] - a.box.hi[axis] > reach);
  }
  return !are_apart;
}

}  // namespace softcd
