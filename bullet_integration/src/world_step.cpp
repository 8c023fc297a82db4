#include "world_step.hpp"

namespace softcd::bullet {

void sweep_boxes(const WorldStep& step) {
  if (!step.queries.settings().rigid_meshes) return;
  for (btSoftBody* body : step.body_span()) sweep_box(*body, *step.world.getBroadphase(), step.world.getDispatcher());
}

void finish_classic_step(const WorldStep& step, btScalar time_step) {
  step.queries.read_out.take_rehearsed_impulses(step.body_span());
  step.queries.prevent_crossings(step.body_span(), step.gate(), time_step);
  step.queries.read_out.finish(*step.world.getBroadphase());
}

void find_soft_contacts(const WorldStep& step) {
  step.queries.find_contacts(step.body_span(), step.gate());
  step.queries.read_contacts(step.body_span(), *step.world.getBroadphase());
}

}  // namespace softcd::bullet
