#pragma once

#include <random>
#include <unordered_map>

#include "read_out/contact_read_out.hpp"

class btDeformableBodySolver;

namespace softcd::bullet {

/// What contacts give in the deformable world.
///
/// Bullet's constraints keep what contacts with rigid objects gave. The solver then goes on with the damping within the
/// soft bodies while it holds nodes in the directions of their contacts: what holds them against that is an impulse of
/// the contacts, too. It is what a node's momentum has changed by without its share of the damping.
class DeformableImpulses {
 public:
  /// Right before Bullet's solver.
  void keep_velocities(Span<btSoftBody* const> bodies);
  /// After Bullet's solver, which keeps what contacts with rigid objects gave until the next step: these impulses;
  /// `bodies` are all of the world's, in its order. `time_step` is 0 where velocities have been changed since: the soft
  /// bodies' impulses are those of the constraints alone then.
  void read_rigid(Span<btSoftBody* const> bodies, btScalar time_step);
  /// And what apply_repulsion() needs, after the same.
  void prepare(Span<btSoftBody* const> bodies, btScalar time_step);
  /// Does what applyRepulsionForce of Bullet's world does, with one contact at a time. Throws nothing.
  void apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step);

  const ContactImpulses& impulses() const { return impulses_; }

 private:
  void add_reactions(btDeformableBodySolver& solver, Span<btSoftBody* const> bodies, btScalar time_step);

  ContactImpulses impulses_;
  std::unordered_map<const btSoftBody*, std::vector<btVector3>> velocities_;  ///< before Bullet's solver
  std::vector<int> order_;  ///< of all active bodies' contacts, one body's after the other's
  std::minstd_rand random_;
};

}  // namespace softcd::bullet
