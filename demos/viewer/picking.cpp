#include "viewer/picking.hpp"

#include <cmath>
#include <limits>

namespace softcd::demo {

// Möller and Trumbore 1997: barycentric coordinates by Cramer's rule.
std::optional<double> distance_to_triangle(const Ray& ray, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a;
  const Vec3d ac = c - a;
  const Vec3d p = cross(ray.direction, ac);
  const double determinant = dot(ab, p);
  if (determinant == 0) return std::nullopt;
  const Vec3d from_a = ray.origin - a;
  const double u = dot(from_a, p) / determinant;
  const Vec3d q = cross(from_a, ab);
  const double v = dot(ray.direction, q) / determinant;
  const double distance = dot(ac, q) / determinant;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && distance > 0)) return std::nullopt;
  return distance;
}

std::optional<Vec3d> meet_plane(const Ray& ray, Vec3d point, Vec3d normal) {
  const double distance = dot(point - ray.origin, normal) / dot(ray.direction, normal);
  if (!(distance > 0 && std::isfinite(distance))) return std::nullopt;
  return ray.origin + distance * ray.direction;
}

std::optional<PickedFace> pick_face(const std::vector<btSoftBody*>& bodies, const Ray& ray) {
  std::optional<PickedFace> nearest;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (int f = 0; f < bodies[b]->m_faces.size(); ++f) {
      const auto& nodes = bodies[b]->m_faces[f].m_n;
      const auto distance =
          distance_to_triangle(ray, to_vec3d(nodes[0]->m_x), to_vec3d(nodes[1]->m_x), to_vec3d(nodes[2]->m_x));
      if (!distance || (nearest && nearest->distance <= *distance)) continue;
      nearest = PickedFace{b, f, *distance, ray.origin + *distance * ray.direction};
    }
  }
  return nearest;
}

int nearest_free_node(const btSoftBody& body, const PickedFace& picked) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const btSoftBody::Node* node : body.m_faces[picked.face].m_n) {
    const double squared_distance = squared_norm(to_vec3d(node->m_x) - picked.position);
    if (node->m_im == 0 || squared_distance >= least) continue;
    least = squared_distance;
    nearest = static_cast<int>(node - &body.m_nodes[0]);
  }
  return nearest;
}

}  // namespace softcd::demo
