#pragma once

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/bullet/settings.hpp"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

using NodePosition = btVector3 btSoftBody::Node::*;

/// Which soft bodies of a kind of world are softcd's, and where their nodes are at the ends of a step.
struct NodeEnds {
  /// The flag of btSoftBody::fCollision whose bodies get vertex-face contacts from softcd.
  int vertex_face_flag;
  /// The members with the positions at the step's ends, while softcd looks for contacts and crossings.
  NodePosition start, end;
};

/// btSoftRigidDynamicsWorld and btSoftMultiBodyDynamicsWorld: contacts are found when the nodes have been moved.
inline constexpr NodeEnds kClassicEnds = {btSoftBody::fCollision::VF_SS, &btSoftBody::Node::m_q,
                                          &btSoftBody::Node::m_x};
/// btDeformableMultiBodyDynamicsWorld: contacts are found before the nodes move.
inline constexpr NodeEnds kDeformableEnds = {btSoftBody::fCollision::VF_DD, &btSoftBody::Node::m_x,
                                             &btSoftBody::Node::m_q};

/// Returns where the body's nodes are when the step begins. A body that sleeps was not predicted: its m_q means
/// nothing.
inline NodePosition start_of(const NodeEnds& ends, const btSoftBody& body) {
  return body.isActive() ? ends.start : &btSoftBody::Node::m_x;
}

/// Whether softcd, not Bullet, is responsible for the contacts of a pair, or of a body with itself: Bullet's own rule.
inline bool is_vertex_face_pair(const NodeEnds& ends, const btSoftBody& a, const btSoftBody& b) {
  return (a.m_cfg.collisions & b.m_cfg.collisions & btSoftBody::fCollision::SVSmask) == ends.vertex_face_flag;
}

inline bool has_vertex_face_contacts(const NodeEnds& ends, const btSoftBody& body) {
  return (body.m_cfg.collisions & ends.vertex_face_flag) != 0 && body.m_nodes.size() > 0;
}

/// Returns margin, self-collision, features and whether contacts can move the body, as they are now.
BodySettings read_settings(const NodeEnds& ends, const btSoftBody& body, const Settings& settings);

}  // namespace softcd::bullet
