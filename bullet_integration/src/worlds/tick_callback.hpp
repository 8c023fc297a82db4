#pragma once

#include "BulletDynamics/Dynamics/btDynamicsWorld.h"

namespace softcd::bullet {

/// Replaces one of the world's two tick callbacks from construction to give_back(), and keeps the app's.
class TickCallback {
 public:
  enum class Place : bool { after, before };  ///< prediction and detection; as Bullet's isPreTick

  TickCallback(btDynamicsWorld& world, Place place, btInternalTickCallback ours);

  /// Installs softcd's callback. Returns whether it was missing; a callback that the app has set is kept then.
  bool stand();
  /// Restores the app's callback, unless the app has set another one since.
  void give_back();
  /// Calls the app's callback, if there is one. That call may destroy this object.
  void call_apps(btScalar time_step) const;

 private:
  btDynamicsWorld& world_;
  Place place_;
  btInternalTickCallback ours_;
  btInternalTickCallback apps_ = nullptr;
};

}  // namespace softcd::bullet
