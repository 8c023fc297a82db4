#include "viewer/node_drag.hpp"

#include <algorithm>

#include "viewer/picking.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kRate = 60;     // speed per distance to the goal, 1/s
constexpr btScalar kFastest = 20;  // units per second

}  // namespace

void NodeDrag::take(const std::vector<btSoftBody*>& bodies, std::size_t body, int node, const OrbitCamera& camera,
                    const Ray& cursor) {
  const Vec3d position = to_vec3d(bodies[body]->m_nodes[node].m_x);
  const Vec3d back = camera.frame().back;
  held_ = Held{body, node, position, back, meet_plane(cursor, position, back).value_or(position), position};
}

void NodeDrag::follow(const Ray& cursor) {
  if (!held_) return;
  const std::optional<Vec3d> now = meet_plane(cursor, held_->taken_at, held_->towards_screen);
  if (now) held_->goal = held_->taken_at + (*now - held_->cursor_at_first);
}

void NodeDrag::pull(const std::vector<btSoftBody*>& bodies) const {
  if (!held_) return;
  btSoftBody& body = *bodies[held_->body];
  btSoftBody::Node& node = body.m_nodes[held_->node];
  const Vec3d& goal = held_->goal;
  const btVector3 way = btVector3(btScalar(goal.x), btScalar(goal.y), btScalar(goal.z)) - node.m_x;
  const btScalar speed = std::min(kRate * way.length(), kFastest);
  node.m_v = speed > 0 ? way * (speed / way.length()) : btVector3(0, 0, 0);
  body.activate();
}

NodeDrag::Line NodeDrag::line(const std::vector<btSoftBody*>& bodies) const {
  return {to_vec3d(bodies[held_->body]->m_nodes[held_->node].m_x), held_->goal};
}

}  // namespace softcd::demo
