#include "contacts/contact_detection.hpp"

#include <algorithm>
#include <cmath>

#include "LinearMath/btQuickprof.h"
#include "bodies/query_options.hpp"
#include "native/native_trees.hpp"
#include "softcd/core/parallel.hpp"

// The libraries of both precisions define this function. So the linker refuses a program that contains parts of both,
// and names the reason.
extern "C" void one_program_cannot_link_both_softcd_bullet_and_softcd_bullet_float64() {}

namespace softcd::bullet {
namespace {

bool is_finite(const btSoftBody& body) {
  for (const btSoftBody::Node& node : span_of(body.m_nodes)) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(node.m_x[axis]) || !std::isfinite(node.m_q[axis])) return false;
    }
  }
  return true;
}

/// Returns whether a node moves further than that in the step. Sleeping bodies do not move.
bool moves_further(const btSoftBody& body, btScalar distance) {
  const Span<const btSoftBody::Node> nodes = span_of(body.m_nodes);
  return body.isActive() && std::any_of(nodes.begin(), nodes.end(), [&](const btSoftBody::Node& node) {
           return (node.m_x - node.m_q).length2() > distance * distance;
         });
}

/// Returns the number of contacts of nodes with faces. A query returns those of edges after them.
std::size_t count_node_contacts(Span<const Contact> contacts) {
  const auto* const end = std::partition_point(contacts.begin(), contacts.end(), [](const Contact& contact) {
    return contact.kind == ContactKind::vertex_triangle;
  });
  return static_cast<std::size_t>(end - contacts.begin());
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
      solver_contacts_(kind.make_solver_contacts()) {}

void ContactDetection::follow_settings() {
  query_.set_options(kind_.options(settings_));
}

std::vector<StageReport> ContactDetection::explain() const {
  std::vector<StageReport> stages = query_.explain();
  stages.push_back(report_on_economy(has_chosen_, solver_contacts_->given(), found_));
  return stages;
}

/// Returns whether the query needs both ends of the step.
bool ContactDetection::needs_both_ends() const {
  return query_.options().detection == Detection::ccd || query_.options().motion_margin > 0;
}

void ContactDetection::read(Span<btSoftBody* const> bodies) {
  BT_PROFILE("softcd contacts");
  mirror_.compare(bodies);
  bodies_.clear();
  // Without faces only edges could touch.
  const bool can_touch = settings_.edge_contacts != EdgeContacts::off ||
                         std::any_of(bodies.begin(), bodies.end(), [this](const btSoftBody* body) {
                           return body->m_faces.size() > 0 && has_vertex_face_contacts(kind_.ends, *body);
                         });
  for (btSoftBody* body : bodies) {
    if (!can_touch || !has_vertex_face_contacts(kind_.ends, *body)) continue;
    mirror_.require(*body, needs_both_ends());
    bodies_.push_back(body);
  }
  choose_rule();
}

/// Chooses ContactRule::ahead if it leaves out contacts, and finds all that are in Bullet's boxes. Otherwise chooses
/// ContactRule::distance. Within twice the margins, to which slow nodes reach, all lies ahead. The motion margin counts
/// between bodies only.
void ContactDetection::choose_rule() {
  QueryOptions options = kind_.options(settings_);
  if (options.contact_rule != ContactRule::ahead) return;
  btScalar least_margin = BT_LARGE_FLOAT;
  for (const btSoftBody* body : bodies_) least_margin = btMin(least_margin, body->getCollisionShape()->getMargin());
  const auto is_fast = [&](const btSoftBody* body) { return moves_further(*body, least_margin); };
  const auto is_predicted = [](const btSoftBody* body) { return leaves_lie_ahead(*body); };
  const bool is_of_use = bodies_.size() > 1 && std::any_of(bodies_.begin(), bodies_.end(), is_fast) &&
                         std::all_of(bodies_.begin(), bodies_.end(), is_predicted);
  if (!is_of_use) options.contact_rule = ContactRule::distance;
  if (query_.options().contact_rule != options.contact_rule) query_.set_options(options);
}

void ContactDetection::start(const PairRule& rule) {
  BT_PROFILE("softcd contacts");
  ticket_.reset();
  if (bodies_.empty() && had_no_bodies(query_)) return;
  query_.set_pair_filter(pair_filter(mirror_, rule));
  ticket_ = query_.start();
  query_.set_pair_filter({});
}

void ContactDetection::finish(bool prevents_crossings, const TangledNodes* released) {
  BT_PROFILE("softcd contacts");
  released_ = released;
  prevents_crossings_ = prevents_crossings && settings_.detection == Detection::ccd;
  const Span<const Contact> contacts = ticket_ ? ticket_->wait() : Span<const Contact>();
  find_spoilt(contacts);
  pressure_motion_.read(prevents_crossings_ && kind_.solves_in_turns ? Span<const btSoftBody* const>(bodies_)
                                                                     : Span<const btSoftBody* const>());
  find_tangles(contacts);
  find_anchored_nodes();
  make_solver_contacts(contacts);
  notes_.reset(solver_contacts_->note_count());
  // Nothing throws below: Bullet's arrays get all contacts or none.
  solver_contacts_->write(notes_);
  notes_.arrange();
}

/// Finds the anchored nodes, whose contacts of edges get no response in the deformable world.
void ContactDetection::find_anchored_nodes() {
  anchored_.clear();
  if (kind_.solves_in_turns || settings_.edge_contacts != EdgeContacts::respond) return;
  for (const btSoftBody* body : bodies_) anchored_.add(*body);
}

/// Makes the contacts for Bullet's solver, and lists those of edges.
void ContactDetection::make_solver_contacts(Span<const Contact> contacts) {
  const ContactEconomy economy(kind_, settings_);
  has_chosen_ = economy.chooses();
  found_.of_nodes = count_node_contacts(contacts);
  found_.of_edges = contacts.size() - found_.of_nodes;
  edge_contacts_.resize(found_.of_edges);
  const auto list_and_judge = [&](std::size_t i, const MemberContact& found) {
    if (i >= found_.of_nodes) edge_contacts_[i - found_.of_nodes] = edge_contact_of(found);
    return may_get(found);
  };
  solver_contacts_->make(
      {mirror_, contacts, settings_.detection, economy, anchored_, settings_.read_out != ReadOut::off, list_and_judge});
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

/// Returns whether contacts may be tangled. A discrete detection at the step's end keeps no sides, so it looks for no
/// tangles. One at the start, the deformable world's, does so for the contacts of edges.
bool ContactDetection::looks_for_tangles() const {
  return query_.options().detection == Detection::ccd ||
         (query_.options().step_end == StepEnd::t0 && settings_.edge_contacts == EdgeContacts::respond);
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

/// Returns whether tangles of these bodies lose contacts. Within a body they do so only with Detection::ccd, whose last
/// pass keeps all else from crossing: with `dcd` contacts of edges keep tangles small. Cloths that fold cross in up to
/// four times as many frames without them.
bool ContactDetection::may_be_released(const MemberContact& found) const {
  return settings_.detection == Detection::ccd || found.a.body != found.b.body;
}

void ContactDetection::find_tangles(Span<const Contact> contacts) {
  tangled_.clear();
  if (!looks_for_tangles()) return;
  is_tangled_.resize(contacts.size());
  constexpr std::size_t kContactsAtOnce = 1024;
  parallel::for_ranges(contacts.size(), kContactsAtOnce, [&](std::size_t begin, std::size_t end) {
    std::size_t i = begin;
    FirstFan first;
    mirror_.for_each_contact({contacts.begin() + begin, end - begin}, [&](const MemberContact& found) {
      const bool has_faces = found.contact.kind == ContactKind::edge_edge || is_with_face(found);
      is_tangled_[i++] = has_faces && has_begun_before(found.contact) && may_be_released(found) &&
                         is_tangled(found, kind_.ends, first);
    });
  });
  std::size_t i = 0;
  mirror_.for_each_contact(contacts, [&](const MemberContact& found) {
    if (is_tangled_[i++] != 0) tangled_.add(found);
  });
}

/// Returns whether the solver gets the contact unless the economy drops it.
bool ContactDetection::may_get(const MemberContact& found) const {
  const bool is_edges = found.contact.kind == ContactKind::edge_edge;
  const bool is_wanted = is_edges ? settings_.edge_contacts == EdgeContacts::respond : is_with_face(found);
  return is_wanted && !is_released(found);
}

/// Returns whether the contact is left out, for one of five reasons. Its nodes move out of an intersection. Its
/// features touch, so their sides are unknown, and crossing prevention handles them. Only pressure brings its features
/// together; crossing prevention handles those that meet nevertheless. One body would spoil the other. Or its features
/// are tangled.
bool ContactDetection::is_released(const MemberContact& found) const {
  if (released_ != nullptr && released_->has_one_of(found)) return true;
  if (prevents_crossings_ && is_touching(found, kind_.ends)) return true;
  if (pressure_motion_.is_cause_of(found)) return true;
  const bool would_spoil =
      !spoilt_.empty() && found.a.body != found.b.body && spoilt_.count(found.a.body) + spoilt_.count(found.b.body) > 0;
  return would_spoil || is_released_from_tangles(found);
}

}  // namespace softcd::bullet
