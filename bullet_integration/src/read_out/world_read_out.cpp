#include "read_out/world_read_out.hpp"

namespace softcd::bullet {

void WorldReadOut::follow_settings() {
  if (settings_.read_out == ReadOut::off) contacts_ = {};
}

void WorldReadOut::read(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase, const NotesOfStep& notes) {
  if (settings_.read_out == ReadOut::off) return;
  run([&] { contacts_.read(read_contacts_, bodies, broadphase, notes); });
  if (!is_in_step_) finish(broadphase);
}

void WorldReadOut::finish(btBroadphaseInterface& broadphase) {
  is_in_step_ = false;
  if (settings_.read_out == ReadOut::off || !settings_.on_contacts) return;
  const std::vector<BodyPairContacts>* pairs = nullptr;
  run([&] { pairs = &contacts_.since_last_step(&broadphase); });
  if (pairs != nullptr) settings_.on_contacts(*pairs);
}

void WorldReadOut::replay_solver(Span<btSoftBody* const> bodies) {
  run_for_impulses([&] { replay_.run(bodies); });
}

void WorldReadOut::confirm_replay(Span<btSoftBody* const> bodies) {
  run_for_impulses([&] { replay_.confirm(bodies); });
}

void WorldReadOut::take_replayed_impulses() {
  run_for_impulses([&] { contacts_.set_impulses(replay_.impulses()); });
}

void WorldReadOut::add_crossings(const std::vector<CrossingImpulse>& crossings, Span<btSoftBody* const> bodies) {
  run_for_impulses([&] { contacts_.add_crossings(crossings, bodies); });
}

void WorldReadOut::keep_velocities(Span<btSoftBody* const> bodies) {
  run_for_impulses([&] { deformable_impulses_.keep_velocities(bodies); });
}

bool WorldReadOut::apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step, const BackedNodes& backed) {
  if (!run_for_impulses([&] { deformable_impulses_.prepare(bodies, time_step); })) return false;
  deformable_impulses_.apply_repulsion(bodies, time_step, backed);
  run([&] { contacts_.set_impulses(deformable_impulses_.impulses()); });
  return true;
}

void WorldReadOut::keep_contacts_of_new_sleepers(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase) {
  if (settings_.read_out == ReadOut::off) return;
  run([&] { contacts_.keep_contacts_of_new_sleepers(bodies, broadphase); });
}

void WorldReadOut::take_rigid_impulses(Span<btSoftBody* const> bodies) {
  run_for_impulses([&] {
    deformable_impulses_.read_rigid(bodies, /*time_step=*/0);
    contacts_.set_impulses(deformable_impulses_.impulses());
  });
}

const std::vector<BodyPairContacts>& WorldReadOut::since_last_call(btBroadphaseInterface* broadphase) {
  return contacts_.since_last_call(broadphase);
}

}  // namespace softcd::bullet
