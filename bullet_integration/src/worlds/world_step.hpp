#pragma once

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "native/native_trees.hpp"
#include "worlds/world_queries.hpp"

/// The parts of a step that are the same in softcd's own worlds and in one that softcd is attached to.
namespace softcd::bullet {

using SoftBodies = btAlignedObjectArray<btSoftBody*>;

/// What a step is of. All of it outlives the step.
struct WorldStep {
  btCollisionWorld& world;
  const SoftBodies& bodies;
  WorldQueries& queries;

  Span<btSoftBody* const> body_span() const { return span_of(bodies); }
  PairGate gate() const { return {*world.getDispatcher(), *world.getPairCache(), world.getDispatchInfo()}; }
};

/// Makes soft bodies' boxes in the broad phase enclose the whole step, if softcd finds contacts with rigid objects.
/// Bullet's own boxes enclose one end. A body that moves farther than its size would not be paired with objects that it
/// passes.
void sweep_boxes(Span<btSoftBody* const> bodies, const Settings& settings, btBroadphaseInterface& broadphase,
                 btDispatcher* dispatcher);

/// Before pairs are calculated, when boxes are up to date and rigid objects are where the step begins: keeps these
/// places, and sweeps boxes.
void prepare_pairs(const WorldStep& step);

/// Between Bullet's prediction and its solver in a classic world. `process_natively` makes Bullet process the pairs,
/// which finds no contacts of vertices with faces.
template <class Native>
void process_classic_pairs(const WorldStep& step, Native process_natively) {
  step.queries.process_pairs(step.body_span(), step.gate(), [&] {
    const FaceTreesAway away(step.body_span());
    process_natively();
  });
  step.queries.read_contacts(step.body_span(), *step.world.getBroadphase());
  step.queries.keep_starts(step.body_span());
}

/// When Bullet has moved rigid bodies in a classic world, before its solver of soft bodies.
void prepare_classic_solver(const WorldStep& step);

/// When Bullet's solver of soft bodies has run in a classic world.
void finish_classic_step(const WorldStep& step, btScalar time_step);

/// Between Bullet's prediction and its solver in a deformable world: the part that is about rigid bodies. Clusters of
/// soft bodies go on.
template <class Native>
void process_deformable_pairs(const WorldStep& step, Native process_natively) {
  for_each_near_rigid(*step.world.getPairCache(), refit_deformable_trees);
  step.queries.begin_step(step.body_span());
  step.queries.process_rigid_pairs(step.gate(), [&] {
    const VertexFaceTestsOff off(step.body_span());
    process_natively();
  });
}

/// The part that is about soft bodies alone, before their contacts are answered.
void find_soft_contacts(const WorldStep& step);

}  // namespace softcd::bullet
