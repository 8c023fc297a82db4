#include "deformable_detection.hpp"

#include <algorithm>

#include "LinearMath/btQuickprof.h"
#include "pipeline_options.hpp"

namespace softcd::bullet {
namespace {

/// Bullet's rule within a body (CollideFF_DD): a node touches a face if one of the faces around the node shares no node
/// with it. Nodes that no face has do not touch their own body's faces.
bool is_away_from(const BodyMesh& mesh, std::uint32_t node, std::uint32_t face) {
  const auto first = mesh.faces_of_nodes.begin();
  return std::any_of(first + mesh.first_face_of_node[node], first + mesh.first_face_of_node[node + 1],
                     [&](std::uint32_t other) { return !share_vertex(mesh.triangles[other], mesh.triangles[face]); });
}

/// Whether Bullet has such a contact.
bool is_deformable_contact(const MemberContact& found) {
  if (!is_with_face(found)) return false;
  return &found.a != &found.b || is_away_from(found.b.mesh, found.contact.feature_a, found.contact.feature_b);
}

PipelineOptions discrete_options(const Settings& settings) {
  PipelineOptions options = pipeline_options(settings);
  options.contact_rule = ContactRule::slab;
  return options;
}

}  // namespace

DeformableDetection::DeformableDetection(const Settings& settings)
    : settings_(settings),
      discrete_(discrete_options(settings), settings.log),
      registry_(discrete_),
      prevention_(CrossingPrevention::World::deformable, settings) {
  discrete_.set_pair_filter(
      [this](BodyId a, BodyId b) { return (*rule_)(*registry_.member(a).body, *registry_.member(b).body); });
}

void DeformableDetection::set_settings(const Settings& settings) {
  discrete_.set_options(discrete_options(settings));
  discrete_.set_log(settings.log);
  prevention_.set_settings(settings);
  settings_ = settings;
}

PairRule DeformableDetection::pair_rule(const PairGate& gate) const {
  return [this, &gate](btSoftBody& a, btSoftBody& b) {
    return is_deformable_pair(a, b) && (!settings_.filter_deformables || gate.admits(a, b));
  };
}

void DeformableDetection::synchronize(btSoftBody& body) {
  BodySettings settings = read_settings(body, settings_);
  // Nobody asks the pair rule about a body and itself.
  settings.self_collision = settings.self_collision && is_deformable_pair(body, body);
  SoftBodyRegistry::Member& member = registry_.synchronize(body, settings);
  if (settings.self_collision && member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
  if (settings.features.edge_edge && member.mesh.face_of_edge.empty()) add_faces_of_edges(member.mesh);
  discrete_.set_positions(member.id, positions_x(body));
}

void DeformableDetection::find_contacts(Span<btSoftBody* const> bodies, const PairGate& gate) {
  BT_PROFILE("softcd contacts");
  registry_.compare(bodies);
  for (btSoftBody* body : bodies) {
    const bool takes_part = (body->m_cfg.collisions & btSoftBody::fCollision::VF_DD) != 0 && body->m_nodes.size() > 0;
    if (takes_part) synchronize(*body);
  }
  registry_.remove_absent();
  const PairRule rule = pair_rule(gate);
  rule_ = &rule;
  edge_contacts_.clear();
  registry_.for_each_contact(discrete_.detect(), [&](const MemberContact& found) { write(found); });
}

void DeformableDetection::write(const MemberContact& found) {
  if (found.contact.kind == ContactKind::edge_edge) {
    edge_contacts_.push_back(edge_contact_of(found));
    if (settings_.edge_contacts == EdgeContacts::respond) write_deformable_edge_contact(found);
  } else if (is_deformable_contact(found)) {
    write_deformable_contact(found);
  }
}

void DeformableDetection::prevent_crossings(Span<btSoftBody* const> bodies, const PairGate& gate, btScalar time_step) {
  prevention_.run(bodies, pair_rule(gate), time_step);
}

}  // namespace softcd::bullet
