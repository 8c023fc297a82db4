#include "world_kind.hpp"

#include <algorithm>

#include "native_detection.hpp"
#include "query_options.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;
using Flags = btSoftBody::fCollision;

namespace classic {

QueryOptions contact_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.detection = settings.detection;
  options.motion_margin = settings.detection == Detection::dcd ? kBulletMotionMargin : 0.0F;
  return options;
}

bool asks_gate(const Settings& /*settings*/) {
  return true;
}

int soft_contact_count(const btSoftBody& body) {
  return body.m_scontacts.size();
}

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

btVector3 velocity_change(const Node& node, const NodeStates& before, std::size_t index, btScalar time_step) {
  return (node.m_x - before.ends[index]) / time_step;
}

void hold(Node& node) {
  node.m_x = node.m_q;
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

/// Bullet's rule looks at where the nodes are when the step begins.
QueryOptions contact_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.contact_rule = ContactRule::slab;
  options.step_end = StepEnd::t0;
  return options;
}

bool asks_gate(const Settings& settings) {
  return settings.filter_deformables;
}

bool is_written(const MemberContact& found, Detection /*detection*/) {
  return is_deformable_contact(found);
}

/// All are within their margins.
bool may_close(const MemberContact& /*found*/) {
  return true;
}

/// Springs push at once, and none ends what another has to do.
btScalar margin_cut(const MemberContact& /*one*/, const std::vector<MemberContact>& /*several*/,
                    Detection /*detection*/) {
  return 0;
}

void write_contact(const MemberContact& found, Detection /*detection*/, const ContactShare& share) {
  write_deformable_contact(found, share);
}

int soft_contact_count(const btSoftBody& body) {
  return body.m_faceNodeContacts.size();
}

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

btVector3 velocity_change(const Node& node, const NodeStates& before, std::size_t index, btScalar /*time_step*/) {
  return node.m_v - before.velocities[index];
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

const WorldKind kClassicWorld = {
    .vertex_face_flag = Flags::VF_SS,
    .start = &Node::m_q,
    .end = &Node::m_x,
    .ray_targets = RayTargets::faces_and_tetrahedra,
    .solves_in_turns = true,
    .moves_rigid_bodies_first = true,
    .contact_options = classic::contact_options,
    .asks_gate = classic::asks_gate,
    .is_written = is_soft_contact,
    .may_close = may_close,
    .margin_cut = soft_margin_cut,
    .write_contact = write_soft_contact,
    .write_edge_contact = write_soft_edge_contact,
    .soft_contact_count = classic::soft_contact_count,
    .read_contacts = &ContactReader::read_classic,
    .detect_natively = detect_classic_contacts,
    .set_out = classic::set_out,
    .take_up = classic::take_up,
    .move_end = classic::move_end,
    .passing_velocity = &Node::m_v,
    .velocity_change = classic::velocity_change,
    .hold = classic::hold,
    .settle = classic::settle,
};

const WorldKind kDeformableWorld = {
    .vertex_face_flag = Flags::VF_DD,
    .start = &Node::m_x,
    .end = &Node::m_q,
    .ray_targets = RayTargets::faces,
    .solves_in_turns = false,
    .moves_rigid_bodies_first = false,
    .contact_options = deformable::contact_options,
    .asks_gate = deformable::asks_gate,
    .is_written = deformable::is_written,
    .may_close = deformable::may_close,
    .margin_cut = deformable::margin_cut,
    .write_contact = deformable::write_contact,
    .write_edge_contact = write_deformable_edge_contact,
    .soft_contact_count = deformable::soft_contact_count,
    .read_contacts = &ContactReader::read_deformable,
    .detect_natively = detect_deformable_contacts,
    .set_out = deformable::move_end,
    .take_up = deformable::take_up,
    .move_end = deformable::move_end,
    .passing_velocity = &Node::m_splitv,
    .velocity_change = deformable::velocity_change,
    .hold = deformable::hold,
    .settle = deformable::settle,
};

BodySettings read_settings(const WorldKind& kind, const btSoftBody& body, const Settings& settings) {
  BodySettings result;
  result.margin = std::max(0.0F, static_cast<float>(body.getCollisionShape()->getMargin()));
  result.kinematic = !body.isActive() || is_immovable(body);
  result.self_collision =
      !result.kinematic && wants_self_collision(body, settings.self_collision) && is_vertex_face_pair(kind, body, body);
  result.features = {/*vertex_triangle=*/true, settings.rigid_meshes || settings.edge_contacts != EdgeContacts::off ||
                                                   settings.convex_shapes != ConvexShapes::nodes};
  return result;
}

}  // namespace softcd::bullet
