#pragma once

#include <memory>
#include <utility>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "contact_detection.hpp"
#include "crossing_prevention.hpp"
#include "rigid_mesh_detection.hpp"

namespace softcd::bullet {

/// What softcd looks for in one world, whose kind and settings all of it follows.
class WorldQueries {
 public:
  /// `kind` outlives it.
  WorldQueries(const WorldKind& kind, const Settings& settings)
      : contacts(kind, settings),
        crossings(kind, settings),
        rigid_meshes(kind, settings),
        kind_(kind),
        settings_(settings) {}

  const Settings& settings() const { return settings_; }
  void set_settings(const Settings& settings) {
    contacts.set_settings(settings);
    crossings.set_settings(settings);
    rigid_meshes.set_settings(settings);
    if (settings.rigid_meshes && !settings_.rigid_meshes) forget_algorithms();
    settings_ = settings;
  }

  /// Between Bullet's prediction and its solver: finds the contacts of soft bodies, and those with rigid meshes, while
  /// `process_natively` makes Bullet process all other pairs that the gate's dispatcher knows.
  template <class Native>
  void process_pairs(Span<btSoftBody* const> bodies, const PairGate& gate, Native process_natively) {
    contacts.start(bodies, pair_rule(kind_, gate, settings_));
    process_rigid_pairs(gate, process_natively);
    contacts.finish();
  }
  /// The part of it that is about rigid bodies.
  template <class Native>
  void process_rigid_pairs(const PairGate& gate, Native process_natively) {
    auto* dispatcher = settings_.rigid_meshes ? dynamic_cast<btCollisionDispatcher*>(&gate.dispatcher()) : nullptr;
    if (dispatcher == nullptr) {
      process_natively();
      return;
    }
    if (std::exchange(may_have_foreign_algorithms_, false)) forget_rigid_algorithms(gate.pair_cache(), *dispatcher);
    {
      const CollectingMeshPairs collecting(*dispatcher, mesh_pairs_);
      process_natively();
    }
    rigid_meshes.find_contacts(mesh_pairs_->take(), gate.info().m_timeStep);
  }
  /// Bullet has processed pairs, and keeps the algorithms that it made for them, while nothing was collected.
  void forget_algorithms() { may_have_foreign_algorithms_ = true; }
  /// The other part, after the solver.
  void find_contacts(Span<btSoftBody* const> bodies, const PairGate& gate) {
    contacts.start(bodies, pair_rule(kind_, gate, settings_));
    contacts.finish();
  }
  /// Where Settings::detection is ccd, the last word about where the nodes go: see CrossingPrevention.
  void prevent_crossings(Span<btSoftBody* const> bodies, const PairGate& gate, btScalar time_step) {
    if (settings_.detection == Detection::ccd) crossings.run(bodies, pair_rule(kind_, gate, settings_), time_step);
  }

  ContactDetection contacts;
  CrossingPrevention crossings;
  RigidMeshDetection rigid_meshes;

 private:
  const WorldKind& kind_;
  Settings settings_;
  std::shared_ptr<MeshPairs> mesh_pairs_ = std::make_shared<MeshPairs>();
  bool may_have_foreign_algorithms_ = true;
};

}  // namespace softcd::bullet
