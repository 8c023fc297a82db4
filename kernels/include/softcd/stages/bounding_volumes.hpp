#pragma once

#include "softcd/grid/size_histogram.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/sphere.hpp"
#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// Bit of TriangleShape::flags: a corner moves further in the step than the triangle is wide, so that time slabs pay.
constexpr std::uint32_t kFastTriangle = 1U;
/// Bit of TriangleShape::flags: on the BIG list.
constexpr std::uint32_t kBigTriangle = 2U;

/// What the grid needs to know of a triangle besides its volume.
struct TriangleShape {
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
    volumes[t] = empty_kdop();
    shapes[t] = {0.0F, 0.0F, 0U};
    if (scene.ownership[t] & kLeftOut) return;

    const TriangleMotion motion = load_triangle(scene, t);
    Kdop18 volume = empty_kdop();
    float motion_growth = 0.0F;
    float furthest_move = 0.0F;
    for (int corner = 0; corner < 3; ++corner) {
      extend(volume, motion.t1[corner]);
      if (scene.continuous) {
        extend(volume, motion.t0[corner]);
        furthest_move = larger(furthest_move, max_norm(motion.t1[corner] - motion.t0[corner]));
      }
      motion_growth = larger(motion_growth, scene.vertex_margin(scene.triangles[t].v[corner]));
    }
    inflate(volume, motion_growth);
    const SceneBody& body = scene.bodies[scene.triangle_body[t]];
    if (!overlap(body.reach, volume)) return;

    const float radius = larger(bounding_sphere(motion.t0[0], motion.t0[1], motion.t0[2]).radius,
                                bounding_sphere(motion.t1[0], motion.t1[1], motion.t1[2]).radius);
    volumes[t] = volume;
    shapes[t] = {radius, motion_growth, furthest_move > radius ? kFastTriangle : 0U};
  }
};

/// Histograms of the active triangles' sizes, for ChooseGrid; `counter.count(histogram, value)` counts.
struct MeasureTriangle {
  enum Histogram : int { radius, swept_radius, distance, kCount };

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
