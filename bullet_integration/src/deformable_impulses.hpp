#pragma once

#include <random>

#include "contact_read_out.hpp"

namespace softcd::bullet {

/// What contacts give in the deformable world.
class DeformableImpulses {
 public:
  /// After Bullet's solver, which keeps what contacts with rigid objects gave until the next step: these impulses;
  /// `bodies` are all of the world's, in its order.
  void read_rigid(Span<btSoftBody* const> bodies);
  /// And what apply_repulsion() needs, after the same.
  void prepare(Span<btSoftBody* const> bodies);
  /// Does what applyRepulsionForce of Bullet's world does, with one contact at a time. Throws nothing.
  void apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step);

  const ContactImpulses& impulses() const { return impulses_; }

 private:
  ContactImpulses impulses_;
  std::vector<int> order_;  ///< of all active bodies' contacts, one body's after the other's
  std::minstd_rand random_;
};

}  // namespace softcd::bullet
