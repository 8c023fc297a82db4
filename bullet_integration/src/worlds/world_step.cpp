#include "worlds/world_step.hpp"

#include "bodies/bounds.hpp"
#include "bodies/query_options.hpp"

namespace softcd::bullet {
namespace {

/// Enlarges the body's box in the broad phase to the whole step, from m_q to m_x or back.
void sweep_box(btSoftBody& body, btBroadphaseInterface& broadphase, btDispatcher* dispatcher) {
  // Sleeping bodies have no prediction: their m_q has no meaning.
  if (!body.isActive() || body.getBroadphaseHandle() == nullptr || body.m_nodes.size() == 0) return;
  Bounds box = bounds_of(body, {&btSoftBody::Node::m_q}).grown(body.getCollisionShape()->getMargin());
  box.add({body.m_bounds[0], body.m_bounds[1]});
  broadphase.setAabb(body.getBroadphaseHandle(), box.low, box.high, dispatcher);
}

}  // namespace

void sweep_boxes(Span<btSoftBody* const> bodies, const Settings& settings, btBroadphaseInterface& broadphase,
                 btDispatcher* dispatcher) {
  if (!finds_rigid_contacts(settings)) return;
  for (btSoftBody* body : bodies) sweep_box(*body, broadphase, dispatcher);
}

void prepare_pairs(const WorldStep& step) {
  step.queries.keep_rigid_starts(step.world.getCollisionObjectArray(), step.world.getDispatchInfo().m_timeStep);
  sweep_boxes(step.body_span(), step.queries.settings(), *step.world.getBroadphase(), step.world.getDispatcher());
}

void prepare_classic_solver(const WorldStep& step) {
  step.queries.keep_velocities();
  step.queries.read_out.replay_solver(step.body_span());
}

void finish_classic_step(const WorldStep& step, btScalar time_step) {
  step.queries.read_out.confirm_replay(step.body_span());
  step.queries.answer_late(step.world.getCollisionObjectArray(), time_step);
  step.queries.read_out.take_replayed_impulses();
  step.queries.prevent_crossings(step.body_span(), step.world.getCollisionObjectArray(), step.gate(), time_step);
  step.queries.read_out.finish(*step.world.getBroadphase());
}

void find_soft_contacts(const WorldStep& step) {
  step.queries.find_contacts(step.body_span(), step.gate());
  step.queries.read_contacts(step.body_span(), *step.world.getBroadphase());
}

}  // namespace softcd::bullet
