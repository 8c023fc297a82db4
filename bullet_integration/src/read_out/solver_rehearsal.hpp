#pragma once

#include "read_out/contact_read_out.hpp"

namespace softcd::bullet {

/// What each contact gives in the coming run of Bullet's soft body solver in a classic world, which keeps no impulses.
///
/// All bodies are solved as btSoftBody::solveConstraints would, by Bullet's own functions for each kind of constraint,
/// with the contacts one after the other; the positions before and after a contact tell its impulse. Then everything is
/// put back as it was. Where Bullet's solver has come to other positions than the rehearsal afterwards (clusters, a
/// solver of the app's, a callback that moved something in between), the impulses of those bodies are not known.
class SolverRehearsal {
 public:
  /// When the solver is about to run for these bodies, all of the world's.
  void run(Span<btSoftBody* const> bodies);
  /// When it has run, and these are the bodies in the world: drops the impulses of bodies that went elsewhere.
  void confirm(Span<btSoftBody* const> bodies);
  ContactImpulses& impulses() { return impulses_; }

 private:
  struct Ends {
    const btSoftBody* body;
    const btCollisionObject* object;  ///< the same
    std::vector<btVector3> positions;
  };

  ContactImpulses impulses_;
  std::vector<Ends> ends_;
};

}  // namespace softcd::bullet
