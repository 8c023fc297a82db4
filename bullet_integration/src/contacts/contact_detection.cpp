#include "contacts/contact_detection.hpp"

#include <cmath>

#include "LinearMath/btQuickprof.h"
#include "bodies/query_options.hpp"
#include "contacts/contact_walks.hpp"

// The libraries of both precisions define this function. So the linker refuses a program that contains parts of both,
// and names the reason.
extern "C" void one_program_cannot_link_both_softcd_bullet_and_softcd_bullet_float64() {}

namespace softcd::bullet {
namespace {

bool is_finite(const btSoftBody& body) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btSoftBody::Node& node = body.m_nodes[i];
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(node.m_x[axis]) || !std::isfinite(node.m_q[axis])) return false;
    }
  }
  return true;
}

/// Returns whether solving the body would spread values that are not numbers over its links.
bool is_spoilt(const btSoftBody& body) {
  return !is_finite(body) && body.m_cfg.piterations + body.m_cfg.viterations + body.m_cfg.diterations > 0;
}

}  // namespace

ContactDetection::ContactDetection(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings)
    : kind_(kind),
      mirror_(mirror),
      settings_(settings),
      query_(mirror.scene(), kind.options(settings)),
      economy_(kind, mirror, settings) {}

void ContactDetection::follow_settings() {
  query_.set_options(kind_.options(settings_));
}

std::vector<StageReport> ContactDetection::explain() const {
  std::vector<StageReport> stages = query_.explain();
  stages.push_back(economy_.report());
  return stages;
}

/// Returns whether the query needs both ends of the step.
bool ContactDetection::looks_at_way() const {
  return query_.options().detection == Detection::ccd || query_.options().motion_margin > 0;
}

void ContactDetection::read(Span<btSoftBody* const> bodies) {
  BT_PROFILE("softcd contacts");
  mirror_.compare(bodies);
  has_any_ = false;
  for (btSoftBody* body : bodies) {
    if (!has_vertex_face_contacts(kind_.ends, *body)) continue;
    mirror_.require(*body, looks_at_way());
    has_any_ = true;
  }
}

void ContactDetection::start(const PairRule& rule) {
  BT_PROFILE("softcd contacts");
  ticket_.reset();
  if (!has_any_ && has_looked_at_nothing(query_)) return;
  query_.set_pair_filter(pair_filter(mirror_, rule));
  ticket_ = query_.start();
  query_.set_pair_filter({});
}

void ContactDetection::drop_unread_face_trees(Span<btSoftBody* const> bodies) {
  for (btSoftBody* body : bodies) {
    if (!has_vertex_face_contacts(kind_.ends, *body) || !mirror_.has(*body)) continue;
    WorldMirror::Member& member = mirror_.member(*body);
    member.face_tree.drop_unread_tree(*body, member.topology_changed);
  }
}

void ContactDetection::hide_flags_of_endless_trees(Span<btSoftBody* const> bodies) {
  for (btSoftBody* body : bodies) {
    if (mirror_.has(*body)) mirror_.member(*body).face_tree.hide_flag_of_endless_tree(*body);
  }
}

void ContactDetection::finish(bool looks_at_crossings, const TangledNodes* released) {
  BT_PROFILE("softcd contacts");
  released_ = released;
  releases_touches_ = looks_at_crossings && settings_.detection == Detection::ccd;
  edge_contacts_.clear();
  const Span<const Contact> contacts = ticket_ ? ticket_->wait() : Span<const Contact>();
  find_spoilt(contacts);
  find_tangles(contacts);
  find_used(contacts);
  economy_.choose(contacts, is_used_);
  list_edge_contacts(contacts);
  const bool keeps_notes = settings_.read_out != ReadOut::off;
  notes_.reset(keeps_notes ? contacts.size() : 0);
  // Nothing throws below: Bullet's arrays get all contacts or none.
  mirror_.for_each_contact(contacts, [&](const MemberContact& found) {
    const auto i = static_cast<std::size_t>(&found.contact - contacts.begin());
    const ContactShare share = economy_.share_of(i);
    if (share.count > 0 && is_used_[i] != 0) keeps_notes ? write_and_note(found, share) : write(found, share);
  });
  notes_.arrange();
}

void ContactDetection::list_edge_contacts(Span<const Contact> contacts) {
  mirror_.for_each_contact(edge_contacts_in(contacts),
                           [this](const MemberContact& found) { edge_contacts_.push_back(edge_contact_of(found)); });
}

void ContactDetection::find_spoilt(Span<const Contact> contacts) {
  spoilt_.clear();
  if (!kind_.solves_in_turns || query_.statistics().left_out_triangles == 0) return;
  std::unordered_set<const btSoftBody*> seen;
  mirror_.for_each_contact(contacts, [&](const MemberContact& found) {
    for (const btSoftBody* body : {found.a.body, found.b.body}) {
      if (seen.insert(body).second && is_spoilt(*body)) spoilt_.insert(body);
    }
  });
}

/// Returns whether contacts may be tangled. A discrete detection uses positions at one time and keeps no sides, so it
/// looks for no tangles. The exception is the deformable world's with Detection::ccd and responses to edges: without
/// these responses edges pass through each other, and tangles come and go.
bool ContactDetection::looks_for_tangles() const {
  return query_.options().detection == Detection::ccd ||
         (settings_.detection == Detection::ccd && settings_.edge_contacts == EdgeContacts::respond);
}

/// Returns whether the contact exists at the step's start. Discrete detections are the deformable world's, at the
/// start.
bool ContactDetection::has_begun_before(const Contact& contact) const {
  return query_.options().detection == Detection::dcd || contact.time_of_impact <= 0;
}

/// Returns whether a contact is left out because of a tangle. In the deformable world nodes keep their contacts: like
/// Bullet's own, these hold tangled bodies against their weight. Contacts of edges would drive the tangle, as their
/// normals may be any.
bool ContactDetection::is_released_from_tangles(const MemberContact& found) const {
  const bool is_kept =
      query_.options().detection == Detection::dcd && found.contact.kind == ContactKind::vertex_triangle;
  return !is_kept && has_begun_before(found.contact) && tangled_.has_one_of(found);
}

void ContactDetection::find_tangles(Span<const Contact> contacts) {
  tangled_.clear();
  if (!looks_for_tangles()) return;
  mirror_.for_each_contact(contacts, [&](const MemberContact& found) {
    const bool has_faces = found.contact.kind == ContactKind::edge_edge || is_with_face(found);
    if (has_faces && has_begun_before(found.contact)) tangled_.add(found, kind_.ends);
  });
}

void ContactDetection::find_used(Span<const Contact> contacts) {
  const bool chooses = economy_.chooses();
  is_used_.resize(contacts.size());
  for_each_contact_in_parallel(
      mirror_, contacts, [&](std::size_t i, const MemberContact& found) { is_used_[i] = is_used(found, chooses); });
}

/// Without economy, `write` leaves out what Bullet's formulas leave out.
bool ContactDetection::is_used(const MemberContact& found, bool chooses) const {
  if (found.contact.kind == ContactKind::edge_edge) {
    return settings_.edge_contacts == EdgeContacts::respond && !is_released(found);
  }
  if (!is_with_face(found) || is_released(found)) return false;
  return !chooses || kind_.is_written(found, settings_.detection);
}

/// The contact is in the array of one of the two bodies, for edges of either.
void ContactDetection::write_and_note(const MemberContact& found, const ContactShare& share) {
  const bool is_edges = found.contact.kind == ContactKind::edge_edge;
  const btSoftBody* const sides[2] = {found.a.body, found.b.body};
  const int counts[2] = {kind_.count(*sides[0]), kind_.count(*sides[1])};
  write(found, share);
  for (int i = 0; i < 2; ++i) {
    const int added = kind_.count(*sides[i]) - counts[i];
    if (added == 0) continue;
    notes_.add({{sides[i], ContactArray::soft, counts[i], added},
                is_edges ? sides[0] : nullptr,
                is_edges ? sides[1] : nullptr,
                found.contact});
    return;
  }
}

/// Returns whether the contact is left out, for one of four reasons. Its nodes move out of an intersection. Its
/// features touch, so their sides are unknown, and crossing prevention handles them. One body would spoil the other. Or
/// its features are tangled.
bool ContactDetection::is_released(const MemberContact& found) const {
  if (released_ != nullptr && released_->has_one_of(found)) return true;
  if (releases_touches_ && is_touching(found, kind_.ends)) return true;
  const bool would_spoil =
      !spoilt_.empty() && found.a.body != found.b.body && spoilt_.count(found.a.body) + spoilt_.count(found.b.body) > 0;
  return would_spoil || is_released_from_tangles(found);
}

void ContactDetection::write(const MemberContact& found, const ContactShare& share) const {
  if (found.contact.kind == ContactKind::edge_edge) {
    kind_.write_edges(found);
  } else {
    kind_.write(found, settings_.detection, share);
  }
}

}  // namespace softcd::bullet
