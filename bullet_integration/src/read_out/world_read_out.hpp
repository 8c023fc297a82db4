#pragma once

#include "bodies/guarded.hpp"
#include "read_out/contact_read_out.hpp"
#include "read_out/deformable_impulses.hpp"
#include "read_out/solver_rehearsal.hpp"

namespace softcd::bullet {

/// What Settings::read_out asks for, in the course of a step. Does nothing where that is off.
class WorldReadOut {
 public:
  /// `settings` outlives it.
  WorldReadOut(ReadContacts read_contacts, const Settings& settings)
      : read_contacts_(read_contacts), settings_(settings) {}

  void follow_settings();

  /// A world's step begins, which calls finish() at its end. Without, the step is over when contacts are read.
  void begin_step() {
    is_in_step_ = true;
    rehearsal_ = {};
  }
  /// When all contacts stand in the arrays of these bodies, all of the world's, and before the solver moves them.
  void read(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase, const NotesOfStep& notes);
  void finish(btBroadphaseInterface& broadphase);

  /// Classic worlds: right before the solver of soft bodies runs, and when it has run. `bodies` are in the world then.
  void rehearse_solver(Span<btSoftBody* const> bodies);
  void confirm_rehearsal(Span<btSoftBody* const> bodies);
  /// What the solver gave, to which others add what they give; null where nobody asks for it.
  ContactImpulses* rehearsed_impulses() {
    return settings_.read_out == ReadOut::impulses ? &rehearsal_.impulses() : nullptr;
  }
  void take_rehearsed_impulses();
  /// When the impulses are known: what the last pass of the step gave, to these bodies, all of the world's.
  void add_crossings(const std::vector<CrossingImpulse>& crossings, Span<btSoftBody* const> bodies);
  /// Deformable world: right before Bullet's solver.
  void keep_velocities(Span<btSoftBody* const> bodies);
  /// Deformable world: in place of applyRepulsionForce; false where that is to be called.
  bool apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step);

  /// Deformable world, whose solver has run: gives bodies that it has put to sleep the contacts of the step before.
  void keep_contacts_of_new_sleepers(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase);
  /// Deformable world, where applyRepulsionForce was called: what contacts with rigid objects gave, as long as Bullet's
  /// solver keeps it.
  void take_rigid_impulses(Span<btSoftBody* const> bodies);

  const std::vector<BodyPairContacts>& since_last_call(btBroadphaseInterface* broadphase);

 private:
  /// False when it has failed: there are no contacts then.
  template <class Work>
  bool run(Work work) {
    try {
      work();
      return true;
    } catch (...) {
      contacts_ = {};
      failures_.note(settings_);
      return false;
    }
  }
  /// Returns false also where impulses are not asked for.
  template <class Work>
  bool run_for_impulses(Work work) {
    return settings_.read_out == ReadOut::impulses && run(work);
  }

  ReadContacts read_contacts_;
  const Settings& settings_;
  Failures failures_{"a step goes on without a list of what touches"};
  ContactReadOut contacts_;
  SolverRehearsal rehearsal_;
  DeformableImpulses deformable_impulses_;
  bool is_in_step_ = false;
};

}  // namespace softcd::bullet
