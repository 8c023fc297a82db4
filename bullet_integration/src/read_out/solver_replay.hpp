#pragma once

#include "read_out/contact_read_out.hpp"

namespace softcd::bullet {

/// Simulates the coming run of Bullet's soft body solver in a classic world, to learn the impulse of each contact.
/// Bullet itself stores no impulses.
///
/// Each body is solved as btSoftBody::solveConstraints would, by Bullet's own functions for each kind of constraint,
/// but with one contact after the other. The positions before and after a contact give its impulse. Then everything is
/// restored. If Bullet's solver then arrives at other positions (because of clusters, the app's own solver, or a
/// callback that moves bodies), the impulses of those bodies are not known. Owned by WorldReadOut.
class SolverReplay {
 public:
  /// Runs the simulation. Call it when the solver is about to run. `bodies` are all of the world's.
  void run(Span<btSoftBody* const> bodies);
  /// Drops the impulses of bodies with other positions than simulated. Call it after the solver. `bodies` are the
  /// world's bodies now.
  void confirm(Span<btSoftBody* const> bodies);
  ContactImpulses& impulses() { return impulses_; }

 private:
  struct Ends {
    const btSoftBody* body;
    const btCollisionObject* object;  ///< the same object
    std::vector<btVector3> positions;
  };

  ContactImpulses impulses_;
  std::vector<Ends> ends_;
};

}  // namespace softcd::bullet
