#include "contact_detection.hpp"

#include "LinearMath/btQuickprof.h"

// Defined by the libraries of both precisions: the linker refuses a program that holds parts of both, by this name.
extern "C" void one_program_cannot_link_both_softcd_bullet_and_softcd_bullet_float64() {}

namespace softcd::bullet {
namespace {

bool has_begun_before(const Contact& contact) {
  return contact.time_of_impact <= 0;
}

}  // namespace

ContactDetection::ContactDetection(const WorldKind& kind, const Settings& settings)
    : kind_(kind), settings_(settings), pipeline_(kind.contact_options(settings), settings.log), registry_(pipeline_) {
  pipeline_.set_pair_filter(
      [this](BodyId a, BodyId b) { return (*rule_)(*registry_.member(a).body, *registry_.member(b).body); });
}

void ContactDetection::set_settings(const Settings& settings) {
  pipeline_.set_options(kind_.contact_options(settings));
  pipeline_.set_log(settings.log);
  settings_ = settings;
}

void ContactDetection::start(Span<btSoftBody* const> bodies, const PairRule& rule) {
  BT_PROFILE("softcd contacts");
  registry_.compare(bodies);
  for (btSoftBody* body : bodies) {
    if (has_vertex_face_contacts(kind_, *body)) synchronize(*body);
  }
  registry_.remove_absent();
  rule_ = &rule;
  pipeline_.detect_async();
  rule_ = nullptr;
}

void ContactDetection::synchronize(btSoftBody& body) {
  const BodySettings settings = read_settings(kind_, body, settings_);
  SoftBodyRegistry::Member& member = registry_.synchronize(body, settings);
  const bool needs_faces_of_nodes = settings.self_collision || pipeline_.options().detection == Detection::ccd;
  if (needs_faces_of_nodes && member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
  if (settings.features.edge_edge && member.mesh.face_of_edge.empty()) add_faces_of_edges(member.mesh);
  set_positions(member);
}

/// Contacts are looked for where the nodes are now, and on their way there.
void ContactDetection::set_positions(const SoftBodyRegistry::Member& member) {
  const btSoftBody& body = *member.body;
  const NodePosition now = &btSoftBody::Node::m_x;
  const NodePosition start = start_of(kind_, body);
  if (start == now) {
    pipeline_.set_positions(member.id, positions_of(body, now));
  } else {
    pipeline_.set_positions(member.id, positions_of(body, start), positions_of(body, now));
  }
}

void ContactDetection::drop_unread_face_trees() {
  registry_.for_each([](SoftBodyRegistry::Member& member) {
    member.face_tree.drop_unread_tree(*member.body, member.topology_changed);
  });
}

void ContactDetection::finish() {
  BT_PROFILE("softcd contacts");
  edge_contacts_.clear();
  const Span<const Contact> contacts = pipeline_.wait();
  find_tangles(contacts);
  registry_.for_each_contact(contacts, [&](const MemberContact& found) {
    if (found.contact.kind == ContactKind::edge_edge) edge_contacts_.push_back(edge_contact_of(found));
  });
  // Nothing throws from here on: Bullet's arrays get all contacts or none.
  registry_.for_each_contact(contacts, [&](const MemberContact& found) { write(found); });
}

/// A discrete detection looks at one time alone, and holds nothing on a side.
void ContactDetection::find_tangles(Span<const Contact> contacts) {
  tangled_.clear();
  if (pipeline_.options().detection == Detection::dcd) return;
  registry_.for_each_contact(contacts, [&](const MemberContact& found) {
    const bool has_faces = found.contact.kind == ContactKind::edge_edge || is_with_face(found);
    if (has_faces && has_begun_before(found.contact)) tangled_.add(found, kind_);
  });
}

void ContactDetection::write(const MemberContact& found) const {
  if (has_begun_before(found.contact) && tangled_.has_one_of(found)) return;
  if (found.contact.kind == ContactKind::edge_edge) {
    if (settings_.edge_contacts == EdgeContacts::respond) kind_.write_edge_contact(found);
  } else if (is_with_face(found)) {
    kind_.write_contact(found, settings_.detection);
  }
}

}  // namespace softcd::bullet
