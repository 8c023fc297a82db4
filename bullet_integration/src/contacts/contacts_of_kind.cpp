#include "contacts/contacts_of_kind.hpp"

#include "bodies/query_options.hpp"

namespace softcd::bullet {
namespace {

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

}  // namespace deformable

}  // namespace

const ContactsOfKind kClassicContacts = {
    .ends = kClassicEnds,
    .solves_in_turns = true,
    .options = classic::contact_options,
    .asks_gate = classic::asks_gate,
    .is_written = is_soft_contact,
    .may_close = may_close,
    .margin_cut = soft_margin_cut,
    .write = write_soft_contact,
    .write_edges = write_soft_edge_contact,
    .count = classic::soft_contact_count,
};

const ContactsOfKind kDeformableContacts = {
    .ends = kDeformableEnds,
    .solves_in_turns = false,
    .options = deformable::contact_options,
    .asks_gate = deformable::asks_gate,
    .is_written = deformable::is_written,
    .may_close = deformable::may_close,
    .margin_cut = deformable::margin_cut,
    .write = deformable::write_contact,
    .write_edges = write_deformable_edge_contact,
    .count = deformable::soft_contact_count,
};

}  // namespace softcd::bullet
