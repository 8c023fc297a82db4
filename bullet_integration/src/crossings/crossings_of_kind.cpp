#include "crossings/crossings_of_kind.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

namespace classic {

/// A body that sleeps was not predicted: where it was at the start of its last step means nothing now.
void set_out(btSoftBody& body, btScalar /*time_step*/) {
  if (body.isActive()) return;
  for (int i = 0; i < body.m_nodes.size(); ++i) body.m_nodes[i].m_q = body.m_nodes[i].m_x;
}

/// The nodes' velocities become the mean ones of the step.
void take_up(btSoftBody& body, btScalar time_step) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    Node& node = body.m_nodes[i];
    node.m_v = (node.m_x - node.m_q) / time_step;
  }
}

void move_end(btSoftBody& body, btScalar time_step) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    Node& node = body.m_nodes[i];
    node.m_x = node.m_q + time_step * node.m_v;
  }
}

/// Answers the nodes' own velocities, which need not be the mean ones: Bullet moves a body's nodes, for the contacts of
/// the bodies after it, when it has its velocities already. Changed by what the mean ones were changed by, they could
/// gain energy.
void settle(const AnsweredBodies& answered, const std::vector<Impact>& impacts, ImpactZones& zones) {
  for (const auto& [body, before] : answered) {
    int node = 0;
    for (const btVector3& velocity : before.velocities) body->m_nodes[node++].m_v = velocity;
  }
  apply_inelastic_impulses(impacts);
  zones.move_as_one();
  for (const auto& [body, before] : answered) {
    if (body->isActive()) body->updateNormals();
  }
}

}  // namespace classic

namespace deformable {

/// As Bullet will when it moves the nodes, whose rigid objects it has moved.
void move_end(btSoftBody& body, btScalar time_step) {
  const btScalar fastest = body.getWorldInfo()->m_maxDisplacement / time_step;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    Node& node = body.m_nodes[i];
    for (int axis = 0; axis < 3; ++axis) btClamp(node.m_v[axis], -fastest, fastest);
    node.m_q = node.m_x + time_step * (node.m_v + node.m_splitv);
  }
  for (int i = 0; i < body.m_deformableAnchors.size(); ++i) {
    const btSoftBody::DeformableNodeRigidAnchor& anchor = body.m_deformableAnchors[i];
    anchor.m_node->m_q = anchor.m_cti.m_colObj->getWorldTransform() * anchor.m_local;
  }
}

/// Split velocities end with the step.
void hold(Node& node) {
  node.m_splitv = -node.m_v;
  node.m_q = node.m_x;
}

/// Nodes on anchors go where these are, whatever their velocities, which get them there until they are put back.
void take_up(btSoftBody& body, btScalar time_step) {
  for (int i = 0; i < body.m_deformableAnchors.size(); ++i) {
    Node& node = *body.m_deformableAnchors[i].m_node;
    node.m_v = (node.m_q - node.m_x) / time_step - node.m_splitv;
  }
}

/// The velocities of others are those that were answered.
void settle(const AnsweredBodies& answered, const std::vector<Impact>& /*impacts*/, ImpactZones& /*zones*/) {
  for (const auto& [body, before] : answered) {
    for (int i = 0; i < body->m_deformableAnchors.size(); ++i) {
      Node& node = *body->m_deformableAnchors[i].m_node;
      node.m_v = before.velocities[static_cast<std::size_t>(&node - &body->m_nodes[0])];
    }
  }
}

}  // namespace deformable

}  // namespace

const CrossingsOfKind kClassicCrossings = {
    .ends = kClassicEnds,
    .set_out = classic::set_out,
    .take_up = classic::take_up,
    .move_end = classic::move_end,
    .passing_velocity = &Node::m_v,
    .velocity_change = [](const Node& node, const NodeStates& before, std::size_t index,
                          btScalar time_step) { return (node.m_x - before.ends[index]) / time_step; },
    .hold = [](Node& node) { node.m_x = node.m_q; },
    .settle = classic::settle,
};

const CrossingsOfKind kDeformableCrossings = {
    .ends = kDeformableEnds,
    .set_out = deformable::move_end,
    .take_up = deformable::take_up,
    .move_end = deformable::move_end,
    .passing_velocity = &Node::m_splitv,
    .velocity_change = [](const Node& node, const NodeStates& before, std::size_t index,
                          btScalar) { return node.m_v - before.velocities[index]; },
    .hold = deformable::hold,
    .settle = deformable::settle,
};

}  // namespace softcd::bullet
