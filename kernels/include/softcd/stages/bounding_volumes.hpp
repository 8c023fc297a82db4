#pragma once

#include "softcd/grid/size_histogram.hpp"
#include "softcd/math/end_volumes.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/sphere.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/stages/grid_parameters.hpp"

namespace softcd {

// Bits of TriangleShape::flags. The lowest seven are the triangle's Ownership, kSegment among them.

/// The triangle is on the BIG list.
constexpr std::uint32_t kBigTriangle = 1U << 9;
/// The triangles of the patch take part one by one.
constexpr std::uint32_t kLoosePatch = 1U << 10;
/// The triangle is not within its kept volume. Set by FindEscaped.
constexpr std::uint32_t kEscapedTriangle = 1U << 11;
/// The body wants contacts of this kind.
constexpr std::uint32_t kWantsVertexTriangle = 1U << 7;
constexpr std::uint32_t kWantsEdgeEdge = 1U << 8;

/// Returns the owned features of the kinds that the body wants contacts of, bits as in Ownership.
SOFTCD_HD constexpr std::uint32_t wanted_features(std::uint32_t flags) {
  return flags & (((flags & kWantsVertexTriangle) != 0U ? 7U : 0U) | ((flags & kWantsEdgeEdge) != 0U ? 56U : 0U));
}

/// Properties of a triangle that later stages need besides its volume, in one 16-byte read.
struct alignas(16) TriangleShape {
  float radius;  ///< of the larger of its bounding spheres at t0 and t1, without margin
  float growth;  ///< margin, and motion margin, by which the volume was inflated
  std::uint32_t flags;
  float rounding;  ///< bounds how far rounding has moved its corners; `growth` covers it
};

/// Computes each triangle's 18-DOP over the whole step, inflated by its margin, and, for a continuous detection, the
/// ones at the step's two ends. Triangles that own nothing because a vertex is not finite, and triangles out of their
/// partners' reach, get an empty volume.
struct BoundTriangle {
  SceneView scene;
  Kdop18* volumes;
  EndVolumes* end_volumes;  ///< null unless swept
  TriangleShape* shapes;

  SOFTCD_HD void operator()(std::uint32_t t) const {
    if ((scene.ownership[t] & kLeftOut) != 0U || !bound(t)) leave_out(t);
  }

  SOFTCD_HD void leave_out(std::uint32_t t) const {
    constexpr Kdop18 kEmpty = empty_kdop();
    constexpr EndVolumes kEmptyEnds = softcd::end_volumes(kEmpty, kEmpty);
    volumes[t] = kEmpty;
    if (scene.is_swept) end_volumes[t] = kEmptyEnds;
    shapes[t] = {0.0F, 0.0F, 0U, 0.0F};
  }

  /// See TriangleShape.
  struct Growth {
    float total, rounding;
  };
  SOFTCD_HD Growth growth_of(std::uint32_t t, const SceneBody& body) const {
    float growth = body.margin;
    if (!scene.is_swept && scene.motion_margin > 0.0F) {
      for (const std::uint32_t v : scene.triangles[t].v)
        growth = larger(growth, outward_up(scene.vertex_margin<float>(v)));
    }
    growth = scene.contact_distance(growth);
    if (!body.is_rounded) return {growth, 0.0F};
    const float rounding = rounding_of(load_triangle(scene, t));
    return {rounding > 0.0F ? outward_up(growth + rounding) : growth, rounding};
  }
  SOFTCD_HD std::uint32_t flags_of(std::uint32_t t, const SceneBody& body) const {
    return scene.ownership[t] | (body.vertex_triangle ? kWantsVertexTriangle : 0U) |
           (body.edge_edge ? kWantsEdgeEdge : 0U);
  }

 private:
  /// Returns false, and writes nothing, if the triangle is out of reach.
  SOFTCD_HD bool bound(std::uint32_t t) const {
    const TriangleMotion motion = load_triangle(scene, t);
    const SceneBody& body = scene.bodies[scene.triangle_body[t]];
    const Growth growth = growth_of(t, body);
    const Kdop18 at_t1 = grown_volume(motion.t1, growth.total);
    const Kdop18 at_t0 = scene.is_swept ? grown_volume(motion.t0, growth.total) : at_t1;
    const Kdop18 volume = scene.is_swept ? merged(at_t0, at_t1) : at_t1;
    if (!overlap(body.partner_box, volume)) return false;
    volumes[t] = volume;
    if (scene.is_swept) end_volumes[t] = softcd::end_volumes(at_t0, at_t1);

    float radius = bounding_sphere(motion.t1[0], motion.t1[1], motion.t1[2]).radius;
    if (scene.is_swept) radius = larger(radius, bounding_sphere(motion.t0[0], motion.t0[1], motion.t0[2]).radius);
    shapes[t] = {radius, growth.total, flags_of(t, body), growth.rounding};
    return true;
  }

  static SOFTCD_HD float rounding_of(const TriangleMotion& motion) {
    float rounding = 0.0F;
    for (int corner = 0; corner < 3; ++corner) {
      rounding = larger(rounding, larger(rounding_bound(motion.t0[corner]), rounding_bound(motion.t1[corner])));
    }
    return rounding;
  }
};

/// Returns the half diagonal of a volume's box.
SOFTCD_HD inline float half_diagonal(const Kdop18& volume) {
  const Vec3f lo = {volume.lo[0], volume.lo[1], volume.lo[2]};
  const Vec3f hi = {volume.hi[0], volume.hi[1], volume.hi[2]};
  return 0.5F * length(hi - lo);
}

/// Returns cell_extent() for a volume that was grown by `growth`.
SOFTCD_HD inline float cell_extent(const Kdop18& volume, float growth) {
  constexpr float kBoxCorner = 1.73205081F;
  return cell_extent(larger(half_diagonal(volume) - kBoxCorner * growth, 0.0F), growth);
}

/// Histograms of the active triangles' sizes, for ChooseGrid; `counter.count(histogram, value)` counts.
struct MeasureTriangle {
  enum Histogram : int { at_rest, swept, extent, distance };
  static constexpr int kHistograms = 4;

  const Kdop18* volumes;
  const TriangleShape* shapes;

  template <class Counter>
  SOFTCD_HD void operator()(std::uint32_t t, Counter& counter) const {
    const Kdop18& volume = volumes[t];
    if (is_empty(volume)) return;
    counter.count(at_rest, size_bin(shapes[t].radius + shapes[t].growth));
    counter.count(swept, size_bin(half_diagonal(volume)));
    counter.count(extent, size_bin(cell_extent(volume, shapes[t].growth)));
    counter.count(distance, size_bin(furthest_coordinate(volume)));
  }
};

struct BoundAndMeasure {
  BoundTriangle bound;
  MeasureTriangle measure;

  template <class Counter>
  SOFTCD_HD void operator()(std::uint32_t t, Counter& counter) const {
    bound(t);
    measure(t, counter);
  }
};

}  // namespace softcd
