#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/ray_triangle.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd {

/// A ray against boxes, in float. It enters every box in which the exact test might find a triangle. It starts where it
/// is nearest to the scene's centre, and its parameter is the length along its largest component. All coordinates are
/// then within four of the scene's extents. Boxes grow by more than rounding can move anything there. That includes the
/// test's own roundings, which are relative to the ray's origin.
class BoxRay {
 public:
  /// Returns false if the ray stays away from the scene.
  SOFTCD_HD bool start(const ShearedRay& ray, const ProbedSceneView& scene) {
    length_ = magnitude(ray.direction[ray.kz]);
    const Vec3d d{ray.direction.x / length_, ray.direction.y / length_, ray.direction.z / length_};
    const Vec3d to_centre = scene.centre - ray.origin;
    start_ = dot(to_centre, d) / squared_norm(d);
    const Vec3d begin = ray.origin + start_ * d;
    const double away = max_norm(begin - scene.centre);
    const double growth = 0x1p-20 * (max_norm(scene.centre) + scene.extent) + 0x1p-46 * max_norm(to_centre);
    slack_ = to_float(4.0 * growth);
    for (int axis = 0; axis < 3; ++axis) {
      direction_[axis] = inverse(d[axis]);
      // In place of growing boxes, this moves the values that they are compared with.
      is_down_[axis] = direction_[axis] < 0.0F;
      near_[axis] = to_float(begin[axis] + (is_down_[axis] ? -growth : growth));
      far_[axis] = to_float(begin[axis] + (is_down_[axis] ? growth : -growth));
    }
    return away <= 2.0 * scene.extent + growth;
  }

  /// Returns the length at t, beyond rounding upwards or, with a negative sign, downwards.
  SOFTCD_HD float length_at(double t, float sign) const { return to_float(t * length_ - start_) + sign * slack_; }

  /// Whether the ray passes through the box between the two lengths, and where it enters.
  SOFTCD_HD bool enters(const Box& box, float from, float to, float& begin) const {
    begin = from;
    float end = to;
    for (int axis = 0; axis < 3; ++axis) {
      const float lo = box.lo[axis];
      const float hi = box.hi[axis];
      begin = larger(((is_down_[axis] ? hi : lo) - near_[axis]) * direction_[axis], begin);
      end = smaller(((is_down_[axis] ? lo : hi) - far_[axis]) * direction_[axis], end);
    }
    return begin <= end + slack_;
  }

 private:
  /// Returns the inverse, limited for components so small that they move nothing within the scene.
  static SOFTCD_HD float inverse(double component) {
    constexpr float kMost = 1e30F;
    const double inverse = 1.0 / component;
    return inverse > 1e30 ? kMost : (inverse < -1e30 ? -kMost : static_cast<float>(inverse));
  }

  double length_;  ///< of the direction's largest component
  double start_;   ///< length from the ray's origin
  float direction_[3];
  float near_[3], far_[3];
  bool is_down_[3];
  float slack_;
};

/// Visits leaves that a ray passes through. accept(leaf place, crossing) returns the t beyond which nothing is of
/// interest any more.
template <class Accept>
class RayVisitor {
 public:
  using Key = float;

  SOFTCD_HD RayVisitor(const ProbedSceneView& scene, const Ray& ray, const Accept& accept)
      : scene_(scene), ray_(ray), accept_(accept) {}

  SOFTCD_HD void run() {
    if (!shear(ray_, scene_.origin, sheared_) || !box_ray_.start(sheared_, scene_)) return;
    from_ = box_ray_.length_at(ray_.t_min, -1.0F);
    to_ = box_ray_.length_at(ray_.t_max, 1.0F);
    visit_leaves(scene_.bvh, *this);
  }

  SOFTCD_HD bool enters(const Box& box, float& begin) const { return box_ray_.enters(box, from_, to_, begin); }
  SOFTCD_HD bool still_enters(float begin) const { return begin <= to_; }
  SOFTCD_HD void visit(const BvhLeaf& leaf, std::uint32_t place) {
    if (!scene_.is_asked(leaf)) return;
    RayCrossing crossing;
    if (!find_crossing(sheared_, leaf.x, crossing)) return;
    if (!(crossing.t >= ray_.t_min && crossing.t <= ray_.t_max)) return;
    to_ = box_ray_.length_at(accept_(place, crossing), 1.0F);
  }

 private:
  const ProbedSceneView& scene_;
  const Ray& ray_;
  const Accept& accept_;
  ShearedRay sheared_;
  BoxRay box_ray_;
  float from_, to_;
};

template <class Accept>
SOFTCD_HD void for_each_crossing(const ProbedSceneView& scene, const Ray& ray, const Accept& accept) {
  RayVisitor<Accept>(scene, ray, accept).run();
}

SOFTCD_HD inline RayHit ray_hit(const ProbedSceneView& scene, std::uint32_t place, const RayCrossing& crossing) {
  const BvhLeaf& leaf = scene.bvh.leaves[place];
  const ProbedBody& body = scene.bodies[leaf.body];
  RayHit hit;
  hit.body = {body.id};
  hit.triangle = leaf.triangle - body.first_triangle;
  hit.t = crossing.t;
  for (int corner = 0; corner < 3; ++corner) hit.weights[corner] = static_cast<float>(crossing.weights[corner]);
  const Vec3d x0 = vec3_cast<double>(leaf.x[0]);
  const Vec3d across = cross(vec3_cast<double>(leaf.x[1]) - x0, vec3_cast<double>(leaf.x[2]) - x0);
  if (max_norm(across) > 0.0) hit.normal = vec3_cast<float>(unit_vector(across));
  return hit;
}

/// Finds the first crossing of each ray: of several at the same t the one of the lowest body and triangle.
struct FindFirstHit {
  ProbedSceneView scene;
  const Ray* rays;
  RayHit* hits;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const Ray ray = rays[i];
    RayCrossing first;
    first.t = ray.t_max;
    std::uint32_t first_place = kNoIndex;
    std::uint32_t first_triangle = kNoIndex;
    for_each_crossing(scene, ray, [&](std::uint32_t place, const RayCrossing& crossing) {
      const std::uint32_t triangle = scene.bvh.leaves[place].triangle;
      if (crossing.t < first.t || (crossing.t == first.t && triangle < first_triangle)) {
        first = crossing;
        first_place = place;
        first_triangle = triangle;
      }
      return first.t;
    });
    hits[i] = first_place == kNoIndex ? RayHit() : ray_hit(scene, first_place, first);
  }
};

/// Lists all crossings of each ray, by t.
struct ListHits {
  using Answer = RayHit;

  ProbedSceneView scene;
  const Ray* rays;

  template <class Sink>
  SOFTCD_HD void list(std::uint32_t i, Sink& sink) const {
    const Ray ray = rays[i];
    for_each_crossing(scene, ray, [&](std::uint32_t place, const RayCrossing& crossing) {
      sink.add([&] { return ray_hit(scene, place, crossing); });
      return ray.t_max;
    });
  }

  static SOFTCD_HD bool is_before(const RayHit& a, const RayHit& b) {
    if (a.t != b.t) return a.t < b.t;
    return a.body.value != b.body.value ? a.body.value < b.body.value : a.triangle < b.triangle;
  }
};

}  // namespace softcd
