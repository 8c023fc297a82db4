#pragma once

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletSoftBody/btSoftBody.h"

class btCollisionDispatcher;

namespace softcd::bullet {

/// Makes the near callback of `dispatcher` tell a PairGate which pairs of soft bodies it lets through. Outside of
/// PairGate::admits, pairs are processed by Bullet as before.
void install_pair_recorder(btCollisionDispatcher& dispatcher);

/// Asks everything but the bodies' flags that decides in Bullet whether two soft bodies may collide: filter groups and
/// masks or the overlap filter callback, the dispatcher's near callback, and through it activation and ignored pairs.
class PairGate {
 public:
  PairGate(btDispatcher& dispatcher, btOverlappingPairCache& pair_cache, const btDispatcherInfo& info)
      : dispatcher_(dispatcher), pair_cache_(pair_cache), info_(info) {}

  bool admits(btSoftBody& a, btSoftBody& b) const;

  btDispatcher& dispatcher() const { return dispatcher_; }
  const btDispatcherInfo& info() const { return info_; }

 private:
  btDispatcher& dispatcher_;
  btOverlappingPairCache& pair_cache_;
  const btDispatcherInfo& info_;
};

}  // namespace softcd::bullet
