#pragma once

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "native/at_end.hpp"
#include "native/native_trees.hpp"
#include "worlds/world_queries.hpp"

namespace softcd::bullet {

using SoftBodies = btAlignedObjectArray<btSoftBody*>;

/// Enlarges soft bodies' boxes in the broad phase to the whole step, if softcd detects contacts with rigid objects.
/// Bullet's own boxes enclose one end only. So a body that moves farther than its size would not be paired with objects
/// that it passes.
void sweep_boxes(Span<btSoftBody* const> bodies, const Settings& settings, btBroadphaseInterface& broadphase,
                 btDispatcher* dispatcher);

/// softcd's part of a world's step, as six moments in the order of Bullet's step:
///
///     begin()            before anything else
///     predict()          around Bullet's prediction
///     pairs()            before pairs are calculated, when boxes are up to date and rigid objects at the step's start
///     process()          around the dispatch of pairs
///     before_solver()    right before the solver of soft bodies
///     end()              after that solver
///
/// softcd's own worlds call them from functions that they override, attached ones from hooks. The order within the
/// last three moments depends on the kind of world: see ClassicStep and DeformableStep.
class StepDriver {
 public:
  /// All arguments must outlive it.
  StepDriver(btCollisionWorld& world, const SoftBodies& bodies, WorldQueries& queries_of_world)
      : queries(queries_of_world), world_(world), bodies_(bodies) {}

  Span<btSoftBody* const> bodies() const { return span_of(bodies_); }

  void begin() const {
    queries.read_out.begin_step();
    queries.massless_paths.begin_step(bodies());
  }
  /// Keeps Bullet from building and updating trees while the returned object lives.
  NodeTreesAtRest predict() const {
    queries.massless_paths.find_moves(bodies());
    return {bodies(), queries.kind().tree_flag};
  }
  /// Saves the poses of rigid objects, begins the paths of massless nodes, and sweeps boxes.
  void pairs() const;

  WorldQueries& queries;

 protected:
  PairGate gate() const { return {*world_.getDispatcher(), *world_.getPairCache(), world_.getDispatchInfo()}; }
  const btCollisionObjectArray& objects() const { return world_.getCollisionObjectArray(); }
  btBroadphaseInterface& broadphase() const { return *world_.getBroadphase(); }

 private:
  btCollisionWorld& world_;
  const SoftBodies& bodies_;
};

/// The moments of a classic world.
class ClassicStep : public StepDriver {
 public:
  using StepDriver::StepDriver;

  /// Detects all contacts. `process_natively` makes Bullet process the pairs; it finds no vertex-face contacts.
  template <class Native>
  void process(Native process_natively) const {
    queries.process_pairs(bodies(), gate(), [&] {
      const FaceTreesAway away(bodies());
      process_natively();
    });
    queries.read_contacts(bodies(), broadphase());
    queries.keep_starts(bodies());
  }
  /// Does the part for soft bodies only, after Bullet has processed the pairs without softcd.
  void process_late() const;
  void before_solver() const;
  void end(btScalar time_step) const;
};

/// The moments of the deformable world. Its contacts between soft bodies come later than those with rigid objects.
class DeformableStep : public StepDriver {
 public:
  using StepDriver::StepDriver;

  /// Detects contacts with rigid objects. Bullet's contacts of clusters stay.
  template <class Native>
  void process(Native process_natively) const {
    for_each_near_rigid(gate().pair_cache(), refit_deformable_trees);
    process_late();
    queries.process_rigid_pairs(gate(), [&] {
      turn_vertex_face_tests_off(bodies());
      const AtEnd dispatched([this] { turn_vertex_face_tests_on(bodies()); });
      process_natively();
    });
  }
  /// Begins the step's detections, after Bullet has processed the pairs without softcd.
  void process_late() const { queries.begin_step(bodies()); }
  void before_solver() const { queries.read_out.keep_velocities(bodies()); }
  /// Detects contacts between soft bodies, before Bullet responds to them. Bullet's solver does not change them: they
  /// depend on the nodes' positions at the start of the step.
  void find_soft_contacts() const;
  /// Responds to these contacts in place of Bullet's applyRepulsionForce() and performGeometricCollisions().
  void respond(btScalar time_step) const;
  /// Runs the last pass. Bullet then moves the nodes.
  void prevent_crossings(btScalar time_step) const;
  /// Corrects the rounding of that motion, right after it, and ends the paths of massless nodes.
  void place_ends() const;
  /// Gives massless nodes that the app has moved their own velocities back, and remembers where all of them are.
  void end_paths() const;
  /// Runs when the nodes have moved.
  void end() const { queries.read_out.finish(broadphase()); }
};

}  // namespace softcd::bullet
