#include "picture.hpp"

#include "scenes/surface_normals.hpp"
#include "scenes/vectors.hpp"

namespace softcd::demo {
namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 800;

void append_triangles(const Surface& surface, std::vector<ShadedTriangle>& triangles) {
  const btSoftBody& body = *surface.body;
  const std::vector<Vec3d> normals = smooth_normals(body);
  for (int f = 0; f < body.m_faces.size(); ++f) {
    ShadedTriangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      const btSoftBody::Node* node = body.m_faces[f].m_n[i];
      triangle.positions[i] = to_vec3d(node->m_x);
      triangle.normals[i] = normals[static_cast<std::size_t>(node - &body.m_nodes[0])];
    }
    triangle.front = {surface.front.red, surface.front.green, surface.front.blue};
    triangle.back = {surface.back.red, surface.back.green, surface.back.blue};
    triangle.has_edges_drawn = surface.has_edges_drawn;
    triangles.push_back(triangle);
  }
}

}  // namespace

Image take_picture(const Scene& scene) {
  std::vector<ShadedTriangle> triangles;
  for (const Surface& surface : scene.surfaces()) append_triangles(surface, triangles);
  const View view = scene.view();
  const Camera camera{to_vec3d(view.eye), to_vec3d(view.target), double(view.field_of_view)};
  return render(triangles, double(view.floor_height), camera, kWidth, kHeight);
}

}  // namespace softcd::demo
