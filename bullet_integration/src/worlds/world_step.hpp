#pragma once

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "native/native_trees.hpp"
#include "worlds/world_queries.hpp"

/// The parts of a step that softcd's own worlds and attached worlds share.
namespace softcd::bullet {

using SoftBodies = btAlignedObjectArray<btSoftBody*>;

/// The objects of a step. All must outlive it.
struct WorldStep {
  btCollisionWorld& world;
  const SoftBodies& bodies;
  WorldQueries& queries;

  Span<btSoftBody* const> body_span() const { return span_of(bodies); }
  PairGate gate() const { return {*world.getDispatcher(), *world.getPairCache(), world.getDispatchInfo()}; }
};

/// Enlarges soft bodies' boxes in the broad phase to the whole step, if softcd detects contacts with rigid objects.
/// Bullet's own boxes enclose one end only. So a body that moves farther than its size would not be paired with objects
/// that it passes.
void sweep_boxes(Span<btSoftBody* const> bodies, const Settings& settings, btBroadphaseInterface& broadphase,
                 btDispatcher* dispatcher);

/// Saves the poses of rigid objects and sweeps boxes. Call it before pairs are calculated, when boxes are up to date
/// and rigid objects are at the start of the step.
void prepare_pairs(const WorldStep& step);

/// Detects contacts in a classic world, between Bullet's prediction and its solver. `process_natively` makes Bullet
/// process the pairs; it finds no vertex-face contacts.
template <class Native>
void process_classic_pairs(const WorldStep& step, Native process_natively) {
  step.queries.process_pairs(step.body_span(), step.gate(), [&] {
    const FaceTreesAway away(step.body_span());
    process_natively();
  });
  step.queries.read_contacts(step.body_span(), *step.world.getBroadphase());
  step.queries.keep_starts(step.body_span());
}

/// Call it in a classic world after Bullet has moved rigid bodies, before its solver of soft bodies.
void prepare_classic_solver(const WorldStep& step);

/// Call it in a classic world after Bullet's solver of soft bodies.
void finish_classic_step(const WorldStep& step, btScalar time_step);

/// Detects contacts with rigid objects in a deformable world, between Bullet's prediction and its solver. Bullet's
/// contacts of clusters stay.
template <class Native>
void process_deformable_pairs(const WorldStep& step, Native process_natively) {
  for_each_near_rigid(*step.world.getPairCache(), refit_deformable_trees);
  step.queries.begin_step(step.body_span());
  step.queries.process_rigid_pairs(step.gate(), [&] {
    const VertexFaceTestsOff off(step.body_span());
    process_natively();
  });
}

/// Detects contacts between soft bodies, before the solver responds to them.
void find_soft_contacts(const WorldStep& step);

}  // namespace softcd::bullet
