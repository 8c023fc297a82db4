#pragma once

#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"

namespace softcd::bullet {

/// Stands in the deformable world's place for a solver callback, from construction to give_back(), and keeps the app's.
/// Bullet calls it twice a step: before its solver and after it.
class SolverCallback {
 public:
  using Function = void (*)(btScalar time, btDeformableMultiBodyDynamicsWorld* world);

  SolverCallback(btDeformableMultiBodyDynamicsWorld& world, Function ours);

  /// Stands there again, if the app has set another one since.
  void stand();
  /// Puts the app's back, unless it has set another one since.
  void give_back();
  /// Calls the app's, if there is one.
  void call_apps(btScalar time) const;

 private:
  btDeformableMultiBodyDynamicsWorld& world_;
  Function ours_;
  Function apps_ = nullptr;
};

}  // namespace softcd::bullet
