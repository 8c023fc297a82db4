#include "snapshot_reader.hpp"

#include <algorithm>
#include <cstddef>

namespace softcd::bullet {
namespace {

Triangle triangle_of(const btSoftBody::Face& face, const btSoftBody::Node* first_node) {
  Triangle triangle{};
  for (int i = 0; i < 3; ++i) triangle.v[i] = static_cast<std::uint32_t>(face.m_n[i] - first_node);
  return triangle;
}

// Every node is fixed: contacts move none of them.
bool is_immovable(const btSoftBody& body) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    if (body.m_nodes[i].m_im > 0) return false;
  }
  return true;
}

bool wants_self_collision(const btSoftBody& body, SelfCollision self_collision) {
  if (self_collision == SelfCollision::flagged) return body.m_useSelfCollision;
  return self_collision == SelfCollision::all;
}

}  // namespace

bool is_up_to_date(const BodyMesh& mesh, const btSoftBody& body) {
  if (mesh.node_count != static_cast<std::uint32_t>(body.m_nodes.size()) ||
      mesh.face_count != static_cast<std::uint32_t>(body.m_faces.size())) {
    return false;
  }
  for (int i = 0; i < body.m_faces.size(); ++i) {
    const Triangle now = triangle_of(body.m_faces[i], &body.m_nodes[0]);
    const Triangle& then = mesh.triangles[static_cast<std::size_t>(i)];
    if (!std::equal(now.v, now.v + 3, then.v)) return false;
  }
  return true;
}

BodyMesh read_mesh(const btSoftBody& body) {
  BodyMesh mesh;
  mesh.node_count = static_cast<std::uint32_t>(body.m_nodes.size());
  mesh.face_count = static_cast<std::uint32_t>(body.m_faces.size());
  mesh.triangles.reserve(mesh.face_count);
  std::vector<bool> has_face(mesh.node_count, false);
  for (int i = 0; i < body.m_faces.size(); ++i) {
    const Triangle triangle = triangle_of(body.m_faces[i], &body.m_nodes[0]);
    for (const std::uint32_t node : triangle.v) {
      if (node < mesh.node_count) has_face[node] = true;
    }
    mesh.triangles.push_back(triangle);
  }
  for (std::uint32_t node = 0; node < mesh.node_count; ++node) {
    if (!has_face[node]) mesh.triangles.push_back({{node, node, node}});
  }
  return mesh;
}

BodySettings read_settings(const btSoftBody& body, SelfCollision self_collision) {
  BodySettings settings;
  settings.margin = std::max(0.0F, static_cast<float>(body.getCollisionShape()->getMargin()));
  settings.kinematic = !body.isActive() || is_immovable(body);
  settings.self_collision = !settings.kinematic && wants_self_collision(body, self_collision);
  settings.features = {/*vertex_triangle=*/true, /*edge_edge=*/false};
  return settings;
}

Positions positions_now(const btSoftBody& body) {
  return {&body.m_nodes[0].m_x.m_floats[0], static_cast<std::size_t>(body.m_nodes.size()), sizeof(btSoftBody::Node)};
}

Positions positions_at_start(const btSoftBody& body) {
  return {&body.m_nodes[0].m_q.m_floats[0], static_cast<std::size_t>(body.m_nodes.size()), sizeof(btSoftBody::Node)};
}

}  // namespace softcd::bullet
