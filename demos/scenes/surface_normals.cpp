#include "scenes/surface_normals.hpp"

#include "scenes/vectors.hpp"

namespace softcd::demo {

std::vector<Vec3d> smooth_normals(const btSoftBody& body) {
  std::vector<Vec3d> normals(static_cast<std::size_t>(body.m_nodes.size()), Vec3d{0, 0, 0});
  for (int f = 0; f < body.m_faces.size(); ++f) {
    const btSoftBody::Face& face = body.m_faces[f];
    const Vec3d a = to_vec3d(face.m_n[0]->m_x);
    const Vec3d normal = cross(to_vec3d(face.m_n[1]->m_x) - a, to_vec3d(face.m_n[2]->m_x) - a);
    for (const btSoftBody::Node* node : face.m_n) {
      Vec3d& sum = normals[static_cast<std::size_t>(node - &body.m_nodes[0])];
      sum = sum + normal;
    }
  }
  return normals;
}

}  // namespace softcd::demo
