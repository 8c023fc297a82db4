#include "worlds/world_step.hpp"

#include "bodies/query_options.hpp"
#include "worlds/sweep_box.hpp"

namespace softcd::bullet {

void prepare_pairs(const WorldStep& step) {
  step.queries.keep_rigid_starts(step.world.getCollisionObjectArray(), step.world.getDispatchInfo().m_timeStep);
  if (!finds_rigid_contacts(step.queries.settings())) return;
  for (btSoftBody* body : step.body_span()) sweep_box(*body, *step.world.getBroadphase(), step.world.getDispatcher());
}

void prepare_classic_solver(const WorldStep& step) {
  step.queries.keep_velocities();
  step.queries.read_out.rehearse_solver(step.body_span());
}

void finish_classic_step(const WorldStep& step, btScalar time_step) {
  step.queries.read_out.confirm_rehearsal(step.body_span());
  step.queries.answer_late(step.world.getCollisionObjectArray(), time_step);
  step.queries.read_out.take_rehearsed_impulses();
  step.queries.prevent_crossings(step.body_span(), step.world.getCollisionObjectArray(), step.gate(), time_step);
  step.queries.read_out.finish(*step.world.getBroadphase());
}

void find_soft_contacts(const WorldStep& step) {
  step.queries.find_contacts(step.body_span(), step.gate());
  step.queries.read_contacts(step.body_span(), *step.world.getBroadphase());
}

}  // namespace softcd::bullet
