#include "worlds/attached_classic_world.hpp"

#include <iterator>

namespace softcd::bullet {

Span<const Limitation> AttachedClassicWorld::limitations() const {
  static constexpr Limitation kLimitations[] = {
      kTreesLimitation,
      {Limit::ends_steps_late,
       "The part of softcd's step after Bullet's solver of soft bodies (the last pass of Detection::ccd, impulses, "
       "on_contacts) waits for finish_step() or the beginning of the next step."},
      kRigidMeshesLimitation,
  };
  return {kLimitations, std::size(kLimitations) - (sees_pairs() ? 1 : 0)};
}

void AttachedClassicWorld::make_up_for_pairs() {
  for (btSoftBody* body : span_of(bodies())) {
    if (body->isActive()) body->m_scontacts.resize(0);  // Bullet's own contacts
  }
  queries().begin_step(span_of(bodies()));
  find_soft_contacts(step());
}

void AttachedClassicWorld::end_step(btScalar time_step) {
  queries().resume_step(span_of(bodies()));
  finish_classic_step(step(), time_step);
}

}  // namespace softcd::bullet
