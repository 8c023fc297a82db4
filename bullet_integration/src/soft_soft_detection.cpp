#include "soft_soft_detection.hpp"

#include "LinearMath/btQuickprof.h"
#include "pipeline_options.hpp"

// Defined by the libraries of both precisions: the linker refuses a program that holds parts of both, by this name.
extern "C" void one_program_cannot_link_both_softcd_bullet_and_softcd_bullet_float64() {}

namespace softcd::bullet {
namespace {

bool has_begun_before(const Contact& contact) {
  return contact.time_of_impact <= 0;
}

PipelineOptions soft_soft_options(const Settings& settings) {
  PipelineOptions options = pipeline_options(settings);
  options.detection = settings.detection;
  options.motion_margin = settings.detection == Detection::dcd ? kBulletMotionMargin : 0.0F;
  return options;
}

}  // namespace

SoftSoftDetection::SoftSoftDetection(const Settings& settings)
    : settings_(settings), pipeline_(soft_soft_options(settings), settings.log), registry_(pipeline_) {
  pipeline_.set_pair_filter([this](BodyId a, BodyId b) {
    return gate_->admits_vertex_face_pair(*registry_.member(a).body, *registry_.member(b).body);
  });
}

void SoftSoftDetection::set_settings(const Settings& settings) {
  pipeline_.set_options(soft_soft_options(settings));
  pipeline_.set_log(settings.log);
  settings_ = settings;
}

void SoftSoftDetection::start(Span<btSoftBody* const> bodies, const PairGate& gate) {
  BT_PROFILE("softcd contacts");
  registry_.compare(bodies);
  for (btSoftBody* body : bodies) {
    const bool takes_part = (body->m_cfg.collisions & btSoftBody::fCollision::VF_SS) != 0 && body->m_nodes.size() > 0;
    if (takes_part) synchronize(*body);
  }
  registry_.remove_absent();
  gate_ = &gate;
  pipeline_.detect_async();
  gate_ = nullptr;
}

void SoftSoftDetection::synchronize(btSoftBody& body) {
  SoftBodyRegistry::Member& member = registry_.synchronize(body, read_settings(body, settings_));
  const bool is_continuous = settings_.detection == Detection::ccd;
  if (is_continuous && member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
  if (settings_.edge_contacts != EdgeContacts::off && member.mesh.face_of_edge.empty()) add_faces_of_edges(member.mesh);
  // A body that sleeps was not predicted: where it was at the start of its last step means nothing now.
  if (body.isActive()) {
    pipeline_.set_positions(member.id, positions_q(body), positions_x(body));
  } else {
    pipeline_.set_positions(member.id, positions_x(body));
  }
}

void SoftSoftDetection::drop_unread_face_trees() {
  registry_.for_each([](SoftBodyRegistry::Member& member) {
    member.face_tree.drop_unread_tree(*member.body, member.topology_changed);
  });
}

void SoftSoftDetection::finish() {
  BT_PROFILE("softcd contacts");
  edge_contacts_.clear();
  const Span<const Contact> contacts = pipeline_.wait();
  find_tangles(contacts);
  registry_.for_each_contact(contacts, [&](const MemberContact& found) { write(found); });
}

/// Bullet's own rule in a discrete detection looks at the end of the step alone, and holds nothing on a side.
void SoftSoftDetection::find_tangles(Span<const Contact> contacts) {
  tangled_.clear();
  if (settings_.detection == Detection::dcd) return;
  registry_.for_each_contact(contacts, [&](const MemberContact& found) {
    const bool has_faces = found.contact.kind == ContactKind::edge_edge || is_with_face(found);
    if (has_faces && has_begun_before(found.contact)) tangled_.add(found);
  });
}

void SoftSoftDetection::write(const MemberContact& found) {
  const bool is_let_go = has_begun_before(found.contact) && tangled_.has_one_of(found);
  if (found.contact.kind == ContactKind::edge_edge) {
    edge_contacts_.push_back(edge_contact_of(found));
    if (settings_.edge_contacts == EdgeContacts::respond && !is_let_go) write_soft_edge_contact(found);
  } else if (is_with_face(found) && !is_let_go) {
    write_soft_contact(found, settings_.detection);
  }
}

}  // namespace softcd::bullet
