#pragma once

#include "softcd/grid/size_histogram.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/sphere.hpp"
#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// Bits of TriangleShape::flags. The lowest six are the triangle's Ownership.
constexpr std::uint32_t kOwnershipBits = 63U;
/// A corner moves further in the step than the triangle is wide, so that time slabs pay.
constexpr std::uint32_t kFastTriangle = 1U << 6;
/// On the BIG list.
constexpr std::uint32_t kBigTriangle = 1U << 7;
/// The body wants contacts of this kind.
constexpr std::uint32_t kWantsVertexTriangle = 1U << 8;
constexpr std::uint32_t kWantsEdgeEdge = 1U << 9;

/// What the later stages need to know of a triangle besides its volume, in one 16-byte read.
struct alignas(16) TriangleShape {
  float radius;  ///< of the larger of its bounding spheres at t0 and t1, without margin
  float growth;  ///< margin, and motion margin, by which the volume was inflated
  std::uint32_t flags;
};

/// Computes each triangle's 18-DOP over the whole step, inflated by its margin. Triangles that own nothing because a
/// vertex is not finite, and triangles out of their partners' reach, get an empty volume.
struct BoundTriangle {
  SceneView scene;
  Kdop18* volumes;
  TriangleShape* shapes;

  SOFTCD_HD void operator()(std::uint32_t t) const {
    Kdop18 volume = empty_kdop();
    TriangleShape shape = {0.0F, 0.0F, 0U};
    if ((scene.ownership[t] & kLeftOut) == 0U) bound(t, volume, shape);
    volumes[t] = volume;
    shapes[t] = shape;
  }

 private:
  SOFTCD_HD void bound(std::uint32_t t, Kdop18& out, TriangleShape& shape) const {
    const TriangleMotion motion = load_triangle(scene, t);
    const SceneBody& body = scene.bodies[scene.triangle_body[t]];
    Kdop18 volume = empty_kdop();
    float growth = body.margin;
    float furthest_move = 0.0F;
    for (int corner = 0; corner < 3; ++corner) {
      extend(volume, motion.t1[corner]);
      if (scene.continuous) {
        extend(volume, motion.t0[corner]);
        furthest_move = larger(furthest_move, max_norm(motion.t1[corner] - motion.t0[corner]));
      } else if (scene.motion_margin > 0.0F) {
        growth = larger(growth, scene.vertex_margin(scene.triangles[t].v[corner]));
      }
    }
    inflate(volume, growth);
    if (!overlap(body.reach, volume)) return;

    float radius = bounding_sphere(motion.t1[0], motion.t1[1], motion.t1[2]).radius;
    if (scene.continuous) radius = larger(radius, bounding_sphere(motion.t0[0], motion.t0[1], motion.t0[2]).radius);
    out = volume;
    shape = {radius, growth,
             scene.ownership[t] | (furthest_move > radius ? kFastTriangle : 0U) |
                 (body.vertex_triangle ? kWantsVertexTriangle : 0U) | (body.edge_edge ? kWantsEdgeEdge : 0U)};
  }
};

/// Histograms of the active triangles' sizes, for ChooseGrid; `counter.count(histogram, value)` counts.
struct MeasureTriangle {
  enum Histogram : int { radius, swept_radius, distance };
  static constexpr int kHistograms = 3;

  const Kdop18* volumes;
  const TriangleShape* shapes;

  template <class Counter>
  SOFTCD_HD void operator()(std::uint32_t t, Counter& counter) const {
    const Kdop18& volume = volumes[t];
    if (is_empty(volume)) return;
    const Vec3f lo = {volume.lo[0], volume.lo[1], volume.lo[2]};
    const Vec3f hi = {volume.hi[0], volume.hi[1], volume.hi[2]};
    counter.count(radius, size_bin(shapes[t].radius + shapes[t].growth));
    counter.count(swept_radius, size_bin(0.5F * sqrtf(squared_norm(hi - lo))));
    counter.count(distance, size_bin(larger(max_norm(lo), max_norm(hi))));
  }
};

}  // namespace softcd
