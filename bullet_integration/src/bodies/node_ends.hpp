#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "native/arrays.hpp"
#include "softcd/bullet/settings.hpp"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

using NodePosition = btVector3 btSoftBody::Node::*;

/// Selects the soft bodies of a kind of world that softcd handles, and names the members with their nodes' positions at
/// the ends of a step.
struct NodeEnds {
  /// The flag of btSoftBody::fCollision: bodies that have it get vertex-face contacts from softcd.
  int vertex_face_flag;
  /// The members that have the positions at the step's ends while softcd detects contacts and crossings.
  NodePosition start, end;
};

/// btSoftRigidDynamicsWorld and btSoftMultiBodyDynamicsWorld. They detect contacts after the nodes have moved.
inline constexpr NodeEnds kClassicEnds = {btSoftBody::fCollision::VF_SS, &btSoftBody::Node::m_q,
                                          &btSoftBody::Node::m_x};
/// btDeformableMultiBodyDynamicsWorld. It detects contacts before the nodes move.
inline constexpr NodeEnds kDeformableEnds = {btSoftBody::fCollision::VF_DD, &btSoftBody::Node::m_x,
                                             &btSoftBody::Node::m_q};
/// Bodies outside of a step, where they are. Selects none.
inline constexpr NodeEnds kPresentEnds = {0, &btSoftBody::Node::m_x, &btSoftBody::Node::m_x};

/// Returns whether Bullet simulates the body neither in this step nor as long as its activation state stays. A sleeping
/// body may still be woken: classic worlds do that after their contacts are detected.
inline bool is_disabled(const btSoftBody& body) {
  return !body.isActive() && body.getActivationState() != ISLAND_SLEEPING;
}

/// Sets a sleeping body's m_q, which is from its last step, to where the body is. Call it before anything moves the
/// body in a step: Bullet's solver moves its nodes in the contacts of other bodies.
inline void set_out_from_sleep(btSoftBody& body) {
  if (body.isActive()) return;
  for (btSoftBody::Node& node : span_of(body.m_nodes)) node.m_q = node.m_x;
}

/// Returns the body's margin; 0 where it is negative or not a number, which would spread to the nodes of other bodies.
inline btScalar margin_of(const btSoftBody& body) {
  const btScalar margin = body.getCollisionShape()->getMargin();
  return margin > 0 ? margin : btScalar(0);
}

/// Returns whether softcd, not Bullet, detects the contacts of a pair, or of a body with itself. This is Bullet's own
/// rule.
inline bool is_vertex_face_pair(const NodeEnds& ends, const btSoftBody& a, const btSoftBody& b) {
  return (a.m_cfg.collisions & b.m_cfg.collisions & btSoftBody::fCollision::SVSmask) == ends.vertex_face_flag;
}

inline bool has_vertex_face_contacts(const NodeEnds& ends, const btSoftBody& body) {
  return (body.m_cfg.collisions & ends.vertex_face_flag) != 0 && body.m_nodes.size() > 0;
}

/// Returns one member of all nodes.
inline std::vector<btVector3> values_of(const btSoftBody& body, NodePosition member) {
  std::vector<btVector3> values;
  values.reserve(static_cast<std::size_t>(body.m_nodes.size()));
  for (const btSoftBody::Node& node : span_of(body.m_nodes)) values.push_back(node.*member);
  return values;
}
/// Sets one member of all nodes. There are as many values as nodes.
inline void set_values(btSoftBody& body, NodePosition member, const std::vector<btVector3>& values) {
  int node = 0;
  for (const btVector3& value : values) body.m_nodes[node++].*member = value;
}

/// Returns the body's present margin, self-collision and features, and whether contacts can move it.
BodySettings read_settings(const NodeEnds& ends, const btSoftBody& body, const Settings& settings);

}  // namespace softcd::bullet
