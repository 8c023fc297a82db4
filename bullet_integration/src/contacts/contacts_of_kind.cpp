#include "contacts/contacts_of_kind.hpp"

#include "bodies/query_options.hpp"

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

struct SoftContacts {
  using Contact = btSoftBody::SContact;

  static auto& array(btSoftBody& body) { return body.m_scontacts; }
  static void add(const MemberContact& found, Detection detection, const ContactShare& share, SoftContactBatch& out) {
    if (found.contact.kind == ContactKind::edge_edge) {
      write_soft_edge_contact(found, out);
    } else {
      write_soft_contact(found, detection, share, out);
    }
  }
};

struct DeformableContacts {
  using Contact = btSoftBody::DeformableFaceNodeContact;

  static auto& array(btSoftBody& body) { return body.m_faceNodeContacts; }
  static void add(const MemberContact& found, Detection /*detection*/, const ContactShare& share,
                  DeformableContactBatch& out) {
    if (found.contact.kind == ContactKind::edge_edge) {
      write_deformable_edge_contact(found, out);
    } else {
      write_deformable_contact(found, share, out);
    }
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
    .is_written = is_soft_contact,
    .is_turned = [](const MemberContact& found,
                    Detection detection) { return detection == Detection::dcd && has_crossed_to_wrong_side(found); },
    .margin_cut = soft_margin_cut,
    .make_solver_contacts = make_solver_contacts<SoftContacts>,
};

// All contacts of a query are within their margins. Springs push at the same time, so no contact ends the approach for
// another.
const ContactsOfKind kDeformableContacts = {
    .ends = kDeformableEnds,
    .solves_in_turns = false,
    .options = deformable_options,
    .asks_gate = [](const Settings& settings) { return settings.filter_deformables; },
    .is_written = [](const MemberContact& found, Detection) { return is_deformable_contact(found); },
    .is_turned = [](const MemberContact&, Detection) { return false; },
    .margin_cut = [](const MemberContact&, const std::vector<MemberContact>&, Detection) { return btScalar(0); },
    .make_solver_contacts = make_solver_contacts<DeformableContacts>,
};

}  // namespace softcd::bullet
