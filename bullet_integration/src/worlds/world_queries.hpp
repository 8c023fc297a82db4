#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "bodies/guarded.hpp"
#include "bodies/query_options.hpp"
#include "contacts/contact_detection.hpp"
#include "crossings/crossing_prevention.hpp"
#include "questions/world_rays.hpp"
#include "read_out/late_impulses.hpp"
#include "read_out/world_read_out.hpp"
#include "rigid/convex_detection.hpp"
#include "rigid/rigid_mesh_detection.hpp"
#include "worlds/world_kind.hpp"

namespace softcd::bullet {

/// What softcd looks for in one world, whose kind and settings all of it follows, and what the world's step goes on
/// with where it fails.
class WorldQueries {
 public:
  /// `kind` outlives it.
  WorldQueries(const WorldKind& kind, const Settings& settings);

  const Settings& settings() const { return settings_; }
  /// Throws as Scene::set_options and Query::set_options; the settings are then as before.
  void set_settings(const Settings& settings);
  void set_filters(const btSoftBody& body, BodyFilters filters) { mirror_.set_filters(body, std::move(filters)); }

  /// Between Bullet's prediction and its solver: finds the contacts of soft bodies, and those with rigid meshes, while
  /// `process_natively` makes Bullet process all other pairs that the gate's dispatcher knows.
  template <class Native>
  void process_pairs(Span<btSoftBody* const> bodies, const PairGate& gate, Native process_natively) {
    begin_step(bodies);
    const bool has_started = start_contacts(bodies, gate);
    process_rigid_pairs(gate, process_natively);
    finish_contacts(has_started, bodies, gate);
  }
  /// The part of it that is about rigid bodies.
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
    late_impulses_.clear();
    // First, while the arrays have nothing but Bullet's own contacts, of which it may take some out.
    if (settings_.convex_shapes != ConvexShapes::nodes) find_convex_contacts(gate);
    if (settings_.rigid_meshes) find_mesh_contacts(*dispatcher, gate);
  }
  /// The other part, after the solver.
  void find_contacts(Span<btSoftBody* const> bodies, const PairGate& gate) {
    finish_contacts(start_contacts(bodies, gate), bodies, gate);
  }
  /// In classic worlds before the solver: see CrossingPrevention.
  void keep_starts(Span<btSoftBody* const> bodies);
  /// In classic worlds when rigid bodies have been moved, before soft bodies are solved, and afterwards.
  void keep_velocities() { late_impulses_.keep_velocities(); }
  void answer_late(const btCollisionObjectArray& objects, btScalar time_step) {
    late_impulses_.answer(objects, time_step, read_out.rehearsed_impulses());
  }
  /// Whether the step's last pass moves the body's nodes where they would cross something. With dcd it does so near
  /// rigid meshes only: links and self-contacts there pull nodes through meshes after contacts have held them off.
  bool prevents_crossings(const btSoftBody& body) const;
  /// The last word about where the nodes go: see CrossingPrevention. Does nothing unless prevents_crossings().
  void prevent_crossings(Span<btSoftBody* const> bodies, const btCollisionObjectArray& objects, const PairGate& gate,
                         btScalar time_step);
  /// Before Bullet moves rigid objects in a step.
  void keep_rigid_starts(const btCollisionObjectArray& objects, btScalar time_step);

  /// When all contacts of a step stand in Bullet's arrays: see WorldReadOut.
  void read_contacts(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase);

  /// Bullet has processed pairs, and keeps the algorithms that it made for them, while nothing was collected.
  void forget_algorithms() { may_have_foreign_algorithms_ = true; }

  /// Before process_rigid_pairs, where that is called for itself.
  void begin_step(Span<btSoftBody* const> bodies) {
    near_meshes_.clear();
    mirror_.begin_step(bodies, stand_ins());
  }
  /// Before prevent_crossings, where the app has had the world in between.
  void resume_step(Span<btSoftBody* const> bodies) { mirror_.resume_step(bodies, stand_ins()); }

 private:
  void follow_settings();

  const WorldKind& kind_;
  Settings settings_;   ///< all that follows sees it
  WorldMirror mirror_;  ///< before what looks at it

 public:
  Guarded<ContactDetection> contacts;
  Guarded<CrossingPrevention> crossings;
  Guarded<RigidMeshDetection> rigid_meshes;
  Guarded<ConvexDetection> convex_shapes;
  WorldReadOut read_out;
  WorldRays rays;
  /// Where the world's bodies are; null when that is gone.
  std::function<btBroadphaseInterface*()> broadphase = [] { return nullptr; };
  /// Whether the step that runs will call prevent_crossings(). A world that leaves its contacts to a Dispatcher sets it
  /// before each dispatch.
  bool prevents_crossings_later = true;

 private:
  Span<btSoftBody* const> stand_ins() const {
    return crossings.get() != nullptr ? crossings.get()->stand_ins() : Span<btSoftBody* const>();
  }
  bool prevents_crossings() const { return settings_.detection == Detection::ccd || settings_.rigid_meshes; }
  WorldPairs pairs_of(const PairGate& gate) const { return {kind_.contacts, gate, settings_}; }
  bool start_contacts(Span<btSoftBody* const> bodies, const PairGate& gate);
  void finish_contacts(bool has_started, Span<btSoftBody* const> bodies, const PairGate& gate);
  void find_mesh_contacts(btCollisionDispatcher& dispatcher, const PairGate& gate);
  void find_convex_contacts(const PairGate& gate);

  std::shared_ptr<RigidPairs> rigid_pairs_ = std::make_shared<RigidPairs>();
  std::vector<const btSoftBody*> near_meshes_;  ///< in this step, ascending
  LateImpulses late_impulses_;
  bool may_have_foreign_algorithms_ = true;
};

}  // namespace softcd::bullet
