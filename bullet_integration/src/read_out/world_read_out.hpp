#pragma once

#include "bodies/guarded.hpp"
#include "read_out/contact_read_out.hpp"
#include "read_out/deformable_impulses.hpp"
#include "read_out/solver_replay.hpp"

namespace softcd::bullet {

/// Reads contacts and impulses in the course of a step as Settings::read_out says. Does nothing if it is off. Owned by
/// WorldQueries; a StepDriver calls it.
class WorldReadOut {
 public:
  /// `settings` must outlive it.
  WorldReadOut(ReadContacts read_contacts, const Settings& settings)
      : read_contacts_(read_contacts), settings_(settings) {}

  void follow_settings();

  /// Begins a step of a world that calls finish() at its end. Without this call, read() ends the step.
  void begin_step() {
    is_in_step_ = true;
    replay_ = {};
  }
  /// Reads the contacts. Call it when all of them are in the arrays of `bodies`, all of the world's, and before the
  /// solver moves these.
  void read(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase, const NotesOfStep& notes);
  void finish(btBroadphaseInterface& broadphase);

  /// Classic worlds: call these right before the solver of soft bodies runs, and right after. `bodies` are in the world
  /// at that time.
  void replay_solver(Span<btSoftBody* const> bodies);
  void confirm_replay(Span<btSoftBody* const> bodies);
  /// Returns the solver's impulses, for others to add theirs; null if the settings need no impulses.
  ContactImpulses* replayed_impulses() {
    return settings_.read_out == ReadOut::impulses ? &replay_.impulses() : nullptr;
  }
  void take_replayed_impulses();
  /// Adds the impulses of the step's last pass. Call it when the contacts' impulses are known. `bodies` are all of the
  /// world's.
  void add_crossings(const std::vector<CrossingImpulse>& crossings, Span<btSoftBody* const> bodies);
  /// Deformable world: call it right before Bullet's solver.
  void keep_velocities(Span<btSoftBody* const> bodies);
  /// Deformable world: responds to contacts between soft bodies. If it returns false, it has done nothing.
  bool apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step, const BackedNodes& backed);

  /// Deformable world, whose solver has run: gives bodies that it has put to sleep the contacts of the step before.
  void keep_contacts_of_new_sleepers(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase);
  /// Deformable world, after applyRepulsionForce: reads the impulses of contacts with rigid objects, while Bullet's
  /// solver still stores them.
  void take_rigid_impulses(Span<btSoftBody* const> bodies);

  const std::vector<BodyPairContacts>& since_last_call(btBroadphaseInterface* broadphase);

 private:
  /// Returns false after a failure; the contacts are then empty.
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
  /// Also returns false if the settings need no impulses.
  template <class Work>
  bool run_for_impulses(Work work) {
    return settings_.read_out == ReadOut::impulses && run(work);
  }

  ReadContacts read_contacts_;
  const Settings& settings_;
  Failures failures_{"the step has no list of contacts"};
  ContactReadOut contacts_;
  SolverReplay replay_;
  DeformableImpulses deformable_impulses_;
  bool is_in_step_ = false;
};

}  // namespace softcd::bullet
