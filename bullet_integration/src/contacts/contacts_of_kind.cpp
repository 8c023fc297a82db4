#include "contacts/contacts_of_kind.hpp"

#include "bodies/query_options.hpp"
#include "contacts/solver_contacts.hpp"

namespace softcd::bullet {
namespace {

QueryOptions classic_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.detection = settings.detection;
  options.motion_margin = settings.detection == Detection::dcd ? kBulletMotionMargin : 0.0F;
  options.contact_rule = ContactRule::ahead;
  return options;
}

/// Bullet's rule uses the nodes' positions at the start of the step.
QueryOptions deformable_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.contact_rule = ContactRule::slab;
  options.step_end = StepEnd::t0;
  return options;
}

template <class Kind>
std::unique_ptr<SolverContacts> make_solver_contacts() {
  return std::make_unique<SolverContactsOf<Kind>>();
}

}  // namespace

const ContactsOfKind kClassicContacts = {
    .ends = kClassicEnds,
    .solves_in_turns = ClassicContacts::kSolvesInTurns,
    .options = classic_options,
    .asks_gate = [](const Settings&) { return true; },
    .make_solver_contacts = make_solver_contacts<ClassicContacts>,
};

const ContactsOfKind kDeformableContacts = {
    .ends = kDeformableEnds,
    .solves_in_turns = DeformableContacts::kSolvesInTurns,
    .options = deformable_options,
    .asks_gate = [](const Settings& settings) { return settings.filter_deformables; },
    .make_solver_contacts = make_solver_contacts<DeformableContacts>,
};

}  // namespace softcd::bullet
