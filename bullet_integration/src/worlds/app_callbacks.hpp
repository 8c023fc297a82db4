#pragma once

#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"

namespace softcd::bullet {

/// Replaces one of the app's callbacks from construction to give_back(), and keeps it. `Place` says which one, how to
/// read it and how to set it.
template <class Place>
class AppCallback {
 public:
  using Function = typename Place::Function;

  AppCallback(typename Place::World& world, Function ours) : world_(world), ours_(ours) { stand(); }

  /// Installs softcd's callback. Returns whether it was missing; a callback that the app has set is kept then.
  bool stand() {
    const Function standing = Place::read(world_);
    if (standing == ours_) return false;
    apps_ = standing;
    Place::set(world_, ours_);
    return true;
  }
  /// Restores the app's callback, unless the app has set another one since.
  void give_back() {
    if (Place::read(world_) == ours_) Place::set(world_, apps_);
  }
  /// Returns the app's callback; null if there is none.
  Function apps() const { return apps_; }

 private:
  typename Place::World& world_;
  Function ours_;
  Function apps_ = nullptr;
};

/// A world's tick callback before prediction and detection, or after them.
template <bool kIsPreTick>
struct TickPlace {
  using World = btDynamicsWorld;
  using Function = btInternalTickCallback;
  static Function read(World& world);
  static void set(World& world, Function function) {
    world.setInternalTickCallback(function, world.getWorldUserInfo(), kIsPreTick);
  }
};

/// The deformable world's solver callback. Bullet calls it twice a step: before its solver and after it.
struct SolverPlace {
  using World = btDeformableMultiBodyDynamicsWorld;
  using Function = void (*)(btScalar time, World* world);
  static Function read(World& world);
  static void set(World& world, Function function) { world.setSolverCallback(function); }
};

using PreTickCallback = AppCallback<TickPlace</*kIsPreTick=*/true>>;
using TickCallback = AppCallback<TickPlace</*kIsPreTick=*/false>>;
using SolverCallback = AppCallback<SolverPlace>;

}  // namespace softcd::bullet
