#include "contacts/contacts_of_kind.hpp"

#include "bodies/query_options.hpp"
#include "contacts/solver_contacts.hpp"

namespace softcd::bullet {
namespace {

QueryOptions classic_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.detection = settings.detection;
  options.motion_margin = settings.detection == Detection::dcd ? kBulletMotionMargin : 0.0F;
  return options;
}

/// Bullet's rule uses the nodes' positions at the start of the step.
QueryOptions deformable_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.contact_rule = ContactRule::slab;
  options.step_end = StepEnd::t0;
  return options;
}

/// Bullet's solver treats contacts in turn.
struct SoftContacts {
  using Contact = btSoftBody::SContact;

  static auto& array(btSoftBody& body) { return body.m_scontacts; }
  static std::optional<Contact> contact_of(const MemberContact& found, Detection detection) {
    return soft_contact(found, detection);
  }
  static bool is_turned(const MemberContact& found, Detection detection, bool is_chosen) {
    const bool may_turn = is_chosen || found.a.body == found.b.body;
    return may_turn && detection == Detection::dcd && has_crossed_to_wrong_side(found);
  }
  static btScalar margin_cut(const MemberContact& one, Span<const Contact> carried, std::size_t place) {
    return soft_margin_cut(one, carried, place);
  }
  static void carry(const MemberContact& /*found*/, const ContactShare& share, Contact& contact) {
    carry_others(share, contact);
  }
  static void add_edges(const MemberContact& found, SoftContactBatch& out) { write_soft_edge_contact(found, out); }
};

/// All contacts of a query are within their margins. Springs push at the same time, so no contact ends the approach for
/// another.
struct DeformableContacts {
  using Contact = btSoftBody::DeformableFaceNodeContact;

  static auto& array(btSoftBody& body) { return body.m_faceNodeContacts; }
  static std::optional<Contact> contact_of(const MemberContact& found, Detection /*detection*/) {
    return deformable_contact(found);
  }
  static bool is_turned(const MemberContact& /*found*/, Detection /*detection*/, bool /*is_chosen*/) { return false; }
  static btScalar margin_cut(const MemberContact& /*one*/, Span<const Contact> /*carried*/, std::size_t /*place*/) {
    return 0;
  }
  static void carry(const MemberContact& found, const ContactShare& share, Contact& contact) {
    carry_others(found, share, contact);
  }
  static void add_edges(const MemberContact& found, DeformableContactBatch& out) {
    write_deformable_edge_contact(found, out);
  }
};

template <class Kind>
std::unique_ptr<SolverContacts> make_solver_contacts() {
  return std::make_unique<SolverContactsOf<Kind>>();
}

}  // namespace

const ContactsOfKind kClassicContacts = {
    .ends = kClassicEnds,
    .solves_in_turns = true,
    .options = classic_options,
    .asks_gate = [](const Settings&) { return true; },
    .make_solver_contacts = make_solver_contacts<SoftContacts>,
};

const ContactsOfKind kDeformableContacts = {
    .ends = kDeformableEnds,
    .solves_in_turns = false,
    .options = deformable_options,
    .asks_gate = [](const Settings& settings) { return settings.filter_deformables; },
    .make_solver_contacts = make_solver_contacts<DeformableContacts>,
};

}  // namespace softcd::bullet
