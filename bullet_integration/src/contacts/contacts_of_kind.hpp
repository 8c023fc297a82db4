#pragma once

#include <memory>

#include "bodies/node_ends.hpp"
#include "native/pair_gate.hpp"

namespace softcd::bullet {

class SolverContacts;

/// The differences between the kinds of world in contacts of soft bodies.
struct ContactsOfKind {
  const NodeEnds& ends;

  /// Whether Bullet solves bodies in turn, each with its links. Then a value that is not a number spreads over its
  /// whole body by the end of the step, and to all bodies that it touches. And one contact can carry others.
  bool solves_in_turns;

  /// Returns the options of the query for contacts between soft bodies.
  QueryOptions (*options)(const Settings&);
  /// Whether PairGate is asked about pairs of soft bodies.
  bool (*asks_gate)(const Settings&);
  /// Makes contacts for Bullet's arrays by contact_writer.hpp.
  std::unique_ptr<SolverContacts> (*make_solver_contacts)();
};

extern const ContactsOfKind kClassicContacts, kDeformableContacts;

/// The PairRule of a world: Bullet's own rule, and the gate if the world asks it. The members must outlive it.
struct WorldPairs {
  const ContactsOfKind& kind;
  const PairGate& gate;
  const Settings& settings;

  bool operator()(btSoftBody& a, btSoftBody& b) const {
    return is_vertex_face_pair(kind.ends, a, b) && (!kind.asks_gate(settings) || gate.admits(a, b));
  }
};

}  // namespace softcd::bullet
