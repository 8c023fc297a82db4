#include "crossings/crossings_of_kind.hpp"

#include <algorithm>
#include <utility>

#include "crossings/link_stretch.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

/// Solves the velocities from before all responses. Rigid bodies with mass get the opposite impulses.
void solve_velocities(const std::vector<Impact>& impacts, ImpactZones& zones) {
  apply_inelastic_impulses(impacts, RigidResponse::impulses);
  zones.move_as_one();
}

namespace classic {

/// Sets the nodes' velocities to the mean ones of the step.
void take_up(btSoftBody& body, btScalar time_step) {
  for (Node& node : span_of(body.m_nodes)) node.m_v = (node.m_x - node.m_q) / time_step;
}

void take_velocities_away(btSoftBody& body) {
  for (Node& node : span_of(body.m_nodes)) node.m_v.setZero();
}

void move_end(btSoftBody& body, btScalar time_step) {
  for (Node& node : span_of(body.m_nodes)) node.m_x = node.m_q + time_step * node.m_v;
}

btVector3 push(Node& node, const btVector3& velocity, const btVector3& shift, btScalar time_step) {
  node.m_v += velocity;
  node.m_x += time_step * velocity + shift;
  return velocity + shift / time_step;
}

/// Applies the responses to the nodes' own velocities. These may differ from the mean ones: Bullet moves a body's nodes
/// for the contacts of later bodies after it has set the body's velocities. If the changes of the mean velocities were
/// added to them, they could gain energy. Inactive bodies do not move by their own velocities, and keep them.
bool finish(const AnsweredBodies& answered, const std::vector<Impact>& impacts, ImpactZones& zones,
            btScalar time_step) {
  for (const auto& [body, before] : answered) {
    set_values(*body, &Node::m_v, before.velocities);
    if (!body->isActive()) take_velocities_away(*body);
  }
  solve_velocities(impacts, zones);
  if (limit_stretch(answered, time_step)) solve_velocities(impacts, zones);
  for (const auto& [body, before] : answered) {
    if (body->isActive()) {
      body->updateNormals();
    } else {
      set_values(*body, &Node::m_v, before.velocities);
    }
  }
  return false;
}

}  // namespace classic

namespace deformable {

/// Moves the nodes' ends as Bullet will. Bullet has already moved the rigid objects of anchors.
void move_end(btSoftBody& body, btScalar time_step) {
  const btScalar fastest = body.getWorldInfo()->m_maxDisplacement / time_step;
  for (Node& node : span_of(body.m_nodes)) {
    for (int axis = 0; axis < 3; ++axis) btClamp(node.m_v[axis], -fastest, fastest);
    node.m_q = node.m_x + time_step * (node.m_v + node.m_splitv);
  }
  for (const btSoftBody::DeformableNodeRigidAnchor& anchor : span_of(body.m_deformableAnchors)) {
    anchor.m_node->m_q = anchor.m_cti.m_colObj->getWorldTransform() * anchor.m_local;
  }
}

/// Keeps sleeping bodies where they are. Bullet goes on to move them out of the rigid contacts of their last step, and
/// no query compares two sleeping bodies.
void set_out(btSoftBody& body, btScalar time_step) {
  move_end(body, time_step);
  if (body.isActive()) return;
  for (Node& node : span_of(body.m_nodes)) node.m_splitv = -node.m_v;
  move_end(body, time_step);
}

btVector3 push(Node& node, const btVector3& velocity, const btVector3& shift, btScalar time_step) {
  node.m_v += velocity;
  node.m_splitv += shift / time_step;
  node.m_q += time_step * velocity + shift;
  return velocity;
}

/// Cancels the velocity by the split velocity, which ends with the step.
void hold(Node& node) {
  node.m_splitv = -node.m_v;
  node.m_q = node.m_x;
}

/// Gives nodes on anchors the velocities that lead to their anchors, and nodes of inactive bodies those of their paths.
/// Their own velocities are restored in finish().
void take_up(btSoftBody& body, btScalar time_step) {
  if (!body.isActive()) {
    for (Node& node : span_of(body.m_nodes)) node.m_v += std::exchange(node.m_splitv, btVector3(0, 0, 0));
  }
  for (const btSoftBody::DeformableNodeRigidAnchor& anchor : span_of(body.m_deformableAnchors)) {
    Node& node = *anchor.m_node;
    node.m_v = (node.m_q - node.m_x) / time_step - node.m_splitv;
  }
}

/// Solves the velocities once more, so that rigid bodies with mass get the opposite impulses. The nodes' ends stay, as
/// Bullet has already moved the rigid bodies: split velocities make up the difference.
void push_rigid_bodies(const AnsweredBodies& answered, const std::vector<Impact>& impacts, ImpactZones& zones,
                       btScalar time_step) {
  for (const auto& [body, before] : answered) {
    set_values(*body, &Node::m_v, before.velocities);
    set_values(*body, &Node::m_splitv, before.split_velocities);
    take_up(*body, time_step);
  }
  solve_velocities(impacts, zones);
  for (const auto& [body, before] : answered) {
    for (Node& node : span_of(body->m_nodes)) node.m_splitv = (node.m_q - node.m_x) / time_step - node.m_v;
  }
}

/// Gives the inactive body its own velocities back. Split velocities, which end with the step, make up the difference.
void restore_velocities(btSoftBody& body, const NodeStates& before) {
  std::size_t index = 0;
  for (Node& node : span_of(body.m_nodes)) {
    const btVector3& own = before.velocities[index++];
    node.m_splitv += node.m_v - own;
    node.m_v = own;
  }
}

/// Restores the velocities of nodes on anchors and of inactive bodies. All other nodes keep the velocities that the
/// responses gave them.
bool finish(const AnsweredBodies& answered, const std::vector<Impact>& impacts, ImpactZones& zones,
            btScalar time_step) {
  const bool has_pushed =
      std::any_of(impacts.begin(), impacts.end(), [](const Impact& i) { return i.rigid != nullptr; });
  if (has_pushed) push_rigid_bodies(answered, impacts, zones, time_step);
  bool are_ends_inexact = has_pushed;
  for (const auto& [body, before] : answered) {
    if (!body->isActive()) {
      restore_velocities(*body, before);
      are_ends_inexact = true;
      continue;
    }
    for (const btSoftBody::DeformableNodeRigidAnchor& anchor : span_of(body->m_deformableAnchors)) {
      Node& node = *anchor.m_node;
      node.m_v = before.velocities[static_cast<std::size_t>(&node - &body->m_nodes[0])];
    }
  }
  return are_ends_inexact;
}

}  // namespace deformable

}  // namespace

const CrossingsOfKind kClassicCrossings = {
    .ends = kClassicEnds,
    .set_out = [](btSoftBody& /*body*/, btScalar /*time_step*/) {},
    .take_up = classic::take_up,
    .move_end = classic::move_end,
    .passing_velocity = &Node::m_v,
    .velocity_change = [](const Node& node, const NodeStates& before, std::size_t index,
                          btScalar time_step) { return (node.m_x - before.ends[index]) / time_step; },
    .push = classic::push,
    .limit_stretch = limit_stretch,
    .hold = [](Node& node) { node.m_x = node.m_q; },
    .finish = classic::finish,
    .parts_soft_bodies_from_start = true,
};

const CrossingsOfKind kDeformableCrossings = {
    .ends = kDeformableEnds,
    .set_out = deformable::set_out,
    .take_up = deformable::take_up,
    .move_end = deformable::move_end,
    .passing_velocity = &Node::m_splitv,
    .velocity_change = [](const Node& node, const NodeStates& before, std::size_t index,
                          btScalar) { return node.m_v - before.velocities[index]; },
    .push = deformable::push,
    .limit_stretch = [](const AnsweredBodies& /*answered*/, btScalar /*time_step*/) { return false; },
    .hold = deformable::hold,
    .finish = deformable::finish,
    .parts_soft_bodies_from_start = false,
};

}  // namespace softcd::bullet
