#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "bodies/guarded.hpp"
#include "bodies/massless_node_paths.hpp"
#include "bodies/query_options.hpp"
#include "contacts/backed_nodes.hpp"
#include "contacts/contact_detection.hpp"
#include "crossings/crossing_prevention.hpp"
#include "crossings/untangling.hpp"
#include "questions/world_rays.hpp"
#include "read_out/late_contacts.hpp"
#include "read_out/late_impulses.hpp"
#include "read_out/world_read_out.hpp"
#include "rigid/convex_policy.hpp"
#include "rigid/mesh_policy.hpp"
#include "worlds/world_kind.hpp"

namespace softcd::bullet {

/// All detections of softcd in one world, with one kind and one copy of the settings, and Bullet's own detection where
/// they fail. Owned by the world's WorldDetection. In each step a StepDriver or a Dispatcher calls it.
class WorldQueries {
 public:
  /// `kind` must outlive it.
  WorldQueries(const WorldKind& kind, const Settings& settings);

  const WorldKind& kind() const { return kind_; }
  /// Returns the settings, with the world's choice in place of EdgeContacts::automatic.
  const Settings& settings() const { return settings_; }
  /// Throws as Scene::set_options and Query::set_options do. The old settings then stay.
  void set_settings(const Settings& settings);

  /// Detects contacts of soft bodies with each other and with rigid objects, between Bullet's prediction and its
  /// solver. `process_natively` makes Bullet process all other pairs of the gate's dispatcher.
  template <class Native>
  void process_pairs(Span<btSoftBody* const> bodies, const PairGate& gate, Native process_natively) {
    begin_step(bodies);
    const bool has_started = start_contacts(bodies, gate);
    process_rigid_pairs(gate, process_natively);
    finish_contacts(has_started, bodies, gate);
  }
  /// Does the part for rigid objects only.
  template <class Native>
  void process_rigid_pairs(const PairGate& gate, Native process_natively) {
    auto* dispatcher =
        finds_rigid_contacts(settings_) ? dynamic_cast<btCollisionDispatcher*>(&gate.dispatcher()) : nullptr;
    if (dispatcher == nullptr) {
      process_natively();
      return;
    }
    if (std::exchange(may_have_foreign_algorithms_, false)) forget_rigid_algorithms(gate.pair_cache(), *dispatcher);
    {
      const CollectingRigidPairs collecting(*dispatcher, rigid_pairs_, settings_.rigid_meshes,
                                            settings_.convex_shapes != ConvexShapes::nodes);
      process_natively();
    }
    late_impulses.clear();
    // Comes first, while the arrays have only Bullet's own contacts, because it may remove some of them.
    if (settings_.convex_shapes != ConvexShapes::nodes) find_convex_contacts(gate);
    if (settings_.rigid_meshes) find_mesh_contacts(*dispatcher, gate);
  }
  /// Does the part for soft bodies only.
  void find_contacts(Span<btSoftBody* const> bodies, const PairGate& gate) {
    finish_contacts(start_contacts(bodies, gate), bodies, gate);
  }
  /// Classic worlds: call it before the solver; see CrossingPrevention.
  void keep_starts(Span<btSoftBody* const> bodies);
  /// Classic worlds: finds the contacts between soft bodies that late_contacts solves again. Call it right before the
  /// solver. With `ccd` the last pass responds to them, and Contacts::all leaves them to Bullet.
  void find_late_contacts(Span<btSoftBody* const> bodies);
  /// Returns whether the step's last pass prevents crossings of the body's nodes. With dcd it does so only near rigid
  /// meshes, where links and self-contacts can pull nodes through a mesh after its contacts were solved.
  bool prevents_crossings(const btSoftBody& body) const;
  /// Returns whether prevent_crossings() may change the ends of the body's nodes.
  bool may_change(const btSoftBody& body) const {
    return prevents_crossings(body) || (untangling.get() != nullptr && untangling.get()->moves(body));
  }
  /// Deformable world: returns the nodes that rigid bodies back, or none if memory runs out.
  BackedNodes backed_nodes(Span<btSoftBody* const> bodies);
  /// Runs the step's last pass: see Untangling and CrossingPrevention. Does nothing unless may_change().
  void prevent_crossings(Span<btSoftBody* const> bodies, const btCollisionObjectArray& objects, const PairGate& gate,
                         btScalar time_step);
  /// See MasslessNodePaths::end_step(). A Dispatcher under a world of Bullet's own never calls it, so nodes there have
  /// no such paths.
  void end_massless_paths(Span<btSoftBody* const> bodies);
  /// Call it before Bullet moves rigid objects in a step.
  void keep_rigid_starts(const btCollisionObjectArray& objects, btScalar time_step);

  /// Call it when all contacts of a step are in Bullet's arrays: see WorldReadOut.
  void read_contacts(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase);

  /// Makes the next step discard the algorithms of pairs. Call it after Bullet has processed pairs that were not
  /// collected, as it keeps the algorithms that it made for them.
  void forget_algorithms() { may_have_foreign_algorithms_ = true; }

  /// Call it before process_rigid_pairs() if that is not called by process_pairs().
  void begin_step(Span<btSoftBody* const> bodies) {
    near_meshes_.clear();
    for (btSoftBody* body : bodies) set_out_from_sleep(*body);
    if (untangling.get() != nullptr) untangles() ? untangling.get()->begin_step() : untangling.get()->clear();
    mirror.begin_step(bodies);
  }

 private:
  void follow_settings();

  const WorldKind& kind_;
  Settings settings_;  ///< all members below refer to it
  Failures failed_responses_{"the step has Bullet's own response to contacts between soft bodies"};
  Failures failed_paths_{"the next step does not know from where the app moves massless nodes"};

 public:
  WorldMirror mirror;  ///< declared before its users
  Guarded<ContactDetection> contacts;
  Guarded<CrossingPrevention> crossings;
  Guarded<Untangling> untangling;
  Guarded<RigidMeshDetection> rigid_meshes;
  Guarded<ConvexDetection> convex_shapes;
  WorldReadOut read_out;
  WorldRays rays;
  LateImpulses late_impulses;  ///< used in classic worlds
  LateContacts late_contacts;  ///< used in classic worlds
  MasslessNodePaths massless_paths;
  /// Returns the world's broad phase, or null if that is gone.
  std::function<btBroadphaseInterface*()> broadphase = [] { return nullptr; };
  /// Whether the present step will call prevent_crossings(). A world that leaves its contacts to a Dispatcher sets it
  /// before each dispatch.
  bool prevents_crossings_later = true;

 private:
  bool prevents_crossings() const { return settings_.detection == Detection::ccd || settings_.rigid_meshes; }
  bool untangles() const { return settings_.untangle != Untangle::off && prevents_crossings_later; }
  WorldPairs pairs_of(const PairGate& gate) const { return {kind_.contacts, gate, settings_}; }
  const TangledNodes* released() const { return untangling.get() != nullptr ? &untangling.get()->nodes() : nullptr; }
  bool start_contacts(Span<btSoftBody* const> bodies, const PairGate& gate);
  void finish_contacts(bool has_started, Span<btSoftBody* const> bodies, const PairGate& gate);
  void read_meshes(RigidMeshDetection& detection, const std::vector<RigidPair>& pairs, btScalar time_step);
  void find_mesh_contacts(btCollisionDispatcher& dispatcher, const PairGate& gate);
  void find_convex_contacts(const PairGate& gate);

  std::shared_ptr<RigidPairs> rigid_pairs_ = std::make_shared<RigidPairs>();
  std::vector<const btSoftBody*> near_meshes_;  ///< in this step, ascending
  bool may_have_foreign_algorithms_ = true;
};

}  // namespace softcd::bullet
