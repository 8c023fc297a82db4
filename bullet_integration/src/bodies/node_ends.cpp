#include "bodies/node_ends.hpp"

#include <algorithm>

namespace softcd::bullet {
namespace {

// All nodes are fixed, so contacts move none of them.
bool is_immovable(const btSoftBody& body) {
  const Span<const btSoftBody::Node> nodes = span_of(body.m_nodes);
  return std::none_of(nodes.begin(), nodes.end(), [](const btSoftBody::Node& node) { return node.m_im > 0; });
}

bool wants_self_collision(const btSoftBody& body, SelfCollision self_collision) {
  if (self_collision == SelfCollision::flagged) return body.m_useSelfCollision;
  return self_collision == SelfCollision::all;
}

}  // namespace

BodySettings read_settings(const NodeEnds& ends, const btSoftBody& body, const Settings& settings) {
  BodySettings result;
  result.margin = static_cast<float>(margin_of(body));
  result.kinematic = !body.isActive() || is_immovable(body);
  result.self_collision =
      !result.kinematic && wants_self_collision(body, settings.self_collision) && is_vertex_face_pair(ends, body, body);
  result.features = {/*vertex_triangle=*/true, settings.rigid_meshes || settings.edge_contacts != EdgeContacts::off ||
                                                   settings.convex_shapes != ConvexShapes::nodes};
  return result;
}

}  // namespace softcd::bullet
