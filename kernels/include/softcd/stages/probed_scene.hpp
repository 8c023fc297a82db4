#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/stages/lbvh.hpp"

namespace softcd {

/// Properties of a body that spatial queries need.
struct ProbedBody {
  std::uint32_t id;
  std::uint32_t first_triangle;
  std::uint32_t triangle_count;
  std::uint32_t first_vertex;
  std::uint32_t vertex_count;
  bool has_positions;
  bool is_asked;   ///< it has positions, and no filter leaves it out
  bool is_closed;  ///< see ClosestPoint::side
};

/// A scene at one end of the step, as spatial queries read it.
struct ProbedSceneView {
  BvhView bvh;
  const ProbedBody* bodies;
  const Triangle* triangles;
  const Ownership* ownership;
  const Vec3f* x;
  /// The given positions, in world coordinates. Null where the question is about the floats, or the floats are exact.
  const Vec3d* full;
  const std::uint32_t* triangle_body;
  Vec3d origin;   ///< positions are relative to it
  Vec3d centre;   ///< of all positions, relative to the origin
  double extent;  ///< no vertex is further from the centre along any axis

  /// Whether the probe is about the leaf's triangle.
  SOFTCD_HD bool is_asked(const BvhLeaf& leaf) const { return leaf.triangle != kNoIndex && bodies[leaf.body].is_asked; }

  /// Returns a triangle as its leaf has it. The leaf has kNoIndex if the triangle is left out, or the probe is not
  /// about it.
  SOFTCD_HD BvhLeaf asked_leaf(std::uint32_t t) const {
    BvhLeaf leaf{};
    leaf.triangle = kNoIndex;
    leaf.body = triangle_body[t];
    if ((ownership[t] & kLeftOut) != 0U || !bodies[leaf.body].is_asked) return leaf;
    leaf.triangle = t;
    for (int corner = 0; corner < 3; ++corner) leaf.x[corner] = x[triangles[t].v[corner]];
    return leaf;
  }
};

/// Returns the nearest float.
SOFTCD_HD inline float to_float(double x) {
  return x > static_cast<double>(FLT_MAX) ? FLT_MAX
                                          : (x < -static_cast<double>(FLT_MAX) ? -FLT_MAX : static_cast<float>(x));
}

}  // namespace softcd
