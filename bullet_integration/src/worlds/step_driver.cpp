#include "worlds/step_driver.hpp"

#include <functional>

#include "bodies/bounds.hpp"
#include "bodies/query_options.hpp"
#include "contacts/soft_response.hpp"

namespace softcd::bullet {
namespace {

/// Enlarges the body's box in the broad phase to the whole step, from m_q to m_x or back.
void sweep_box(btSoftBody& body, btBroadphaseInterface& broadphase, btDispatcher* dispatcher) {
  // Sleeping bodies have no prediction: their m_q has no meaning.
  if (!body.isActive() || body.getBroadphaseHandle() == nullptr || body.m_nodes.size() == 0) return;
  Bounds box = bounds_of(body, {&btSoftBody::Node::m_q}).grown(margin_of(body));
  box.add({body.m_bounds[0], body.m_bounds[1]});
  broadphase.setAabb(body.getBroadphaseHandle(), box.low, box.high, dispatcher);
}

}  // namespace

void sweep_boxes(Span<btSoftBody* const> bodies, const Settings& settings, btBroadphaseInterface& broadphase,
                 btDispatcher* dispatcher) {
  if (!finds_rigid_contacts(settings)) return;
  for (btSoftBody* body : bodies) sweep_box(*body, broadphase, dispatcher);
}

void StepDriver::pairs() const {
  const btScalar time_step = world_.getDispatchInfo().m_timeStep;
  queries.keep_rigid_starts(objects(), time_step);
  queries.massless_paths.set_starts(bodies(), time_step);
  sweep_boxes(bodies(), queries.settings(), broadphase(), world_.getDispatcher());
}

void ClassicStep::process_late() const {
  for (btSoftBody* body : bodies()) {
    if (body->isActive()) body->m_scontacts.resize(0);  // Bullet's own contacts
  }
  queries.begin_step(bodies());
  queries.find_contacts(bodies(), gate());
  queries.read_contacts(bodies(), broadphase());
}

/// Bullet has already moved rigid bodies.
void ClassicStep::before_solver() const {
  queries.late_impulses.keep_velocities();
  queries.find_late_contacts(bodies());
  queries.read_out.replay_solver(bodies());
}

void ClassicStep::end(btScalar time_step) const {
  {
    const AtEnd answered([this] { queries.massless_paths.end_paths(bodies()); });
    queries.read_out.confirm_replay(bodies());
    queries.late_contacts.solve(bodies(), queries.read_out.replayed_impulses());
    queries.late_impulses.answer(objects(), time_step, queries.read_out.replayed_impulses());
    queries.read_out.take_replayed_impulses();
    queries.prevent_crossings(bodies(), objects(), gate(), time_step);
  }
  queries.end_massless_paths(bodies());
  queries.read_out.finish(broadphase());
}

void DeformableStep::find_soft_contacts() const {
  queries.find_contacts(bodies(), gate());
  queries.read_contacts(bodies(), broadphase());
}

void DeformableStep::respond(btScalar time_step) const {
  const BackedNodes backed = queries.backed_nodes(bodies());
  const std::function<bool(const btSoftBody&)> stays = [this](const btSoftBody& body) {
    return queries.prevents_crossings(body);
  };
  const InactiveNodesHeld held(bodies(), stays);
  if (queries.read_out.apply_repulsion(bodies(), time_step, backed)) return;
  respond_to_soft_contacts(bodies(), time_step, [&](bool with_springs) {
    for (btSoftBody* body : bodies()) {
      if (body->isActive()) backed.respond(*body, time_step, with_springs);
    }
  });
}

void DeformableStep::prevent_crossings(btScalar time_step) const {
  queries.prevent_crossings(bodies(), objects(), gate(), time_step);
}

void DeformableStep::place_ends() const {
  if (queries.crossings.get() != nullptr) queries.crossings.get()->place_ends();
  end_paths();
}

void DeformableStep::end_paths() const {
  queries.massless_paths.end_paths(bodies());
  queries.end_massless_paths(bodies());
}

}  // namespace softcd::bullet
