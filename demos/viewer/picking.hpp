#pragma once

#include <optional>
#include <vector>

#include "viewer/camera.hpp"

namespace softcd::demo {

/// A face that a ray meets, by its index among a scene's bodies.
struct PickedFace {
  std::size_t body;
  int face;
  double distance;  ///< along the ray
  Vec3d position;
};

/// Returns the distance along the ray, from either side; none when the ray misses the triangle or the triangle lies
/// behind.
std::optional<double> distance_to_triangle(const Ray& ray, Vec3d a, Vec3d b, Vec3d c);

/// Returns the point of the plane; none when the ray is parallel to the plane or the plane lies behind.
std::optional<Vec3d> meet_plane(const Ray& ray, Vec3d point, Vec3d normal);

/// Returns the first face on the ray.
std::optional<PickedFace> pick_face(const std::vector<btSoftBody*>& bodies, const Ray& ray);

/// Returns the face's node that is nearest to the picked position and can be moved; -1 when none can.
int nearest_free_node(const btSoftBody& body, const PickedFace& picked);

}  // namespace softcd::demo
