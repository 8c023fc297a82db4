#pragma once

#include "BulletDynamics/Dynamics/btDynamicsWorld.h"

namespace softcd::bullet {

/// Stands in one of the world's two places for tick callbacks, from construction to give_back(), and keeps the app's.
class TickCallback {
 public:
  enum class Place : bool { after, before };  ///< prediction and detection; as Bullet's isPreTick

  TickCallback(btDynamicsWorld& world, Place place, btInternalTickCallback ours);

  /// True where it did not stand there yet, or not any more: what the app has set since is kept now.
  bool stand();
  /// Puts the app's back, unless it has set another one since.
  void give_back();
  /// Calls the app's, if there is one, which may destroy this.
  void call_apps(btScalar time_step) const;

 private:
  btDynamicsWorld& world_;
  Place place_;
  btInternalTickCallback ours_;
  btInternalTickCallback apps_ = nullptr;
};

}  // namespace softcd::bullet
