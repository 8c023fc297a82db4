#pragma once

#include <functional>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletSoftBody/btSoftBody.h"

namespace softcd::bullet {

/// Returns whether softcd detects the contacts of two soft bodies.
using PairRule = std::function<bool(btSoftBody&, btSoftBody&)>;

/// Returns the soft bodies of a pair; null for objects of other kinds.
inline std::pair<btSoftBody*, btSoftBody*> soft_bodies_of(const btBroadphasePair& pair) {
  return {btSoftBody::upcast(static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject)),
          btSoftBody::upcast(static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject))};
}

/// Calls visit(pair, soft) for each pair of a soft body with another object.
template <class Visit>
void for_each_pair_with_rigid(btOverlappingPairCache& pair_cache, Visit visit) {
  btBroadphasePair* const pairs = pair_cache.getOverlappingPairArrayPtr();
  for (int i = 0; i < pair_cache.getNumOverlappingPairs(); ++i) {
    const auto [a, b] = soft_bodies_of(pairs[i]);
    if ((a == nullptr) != (b == nullptr)) visit(pairs[i], *(a != nullptr ? a : b));
  }
}

/// Decides whether two objects may collide, by everything that Bullet asks except the bodies' flags: filter groups and
/// masks or the overlap filter callback, the dispatcher's near callback, and through it activation and ignored pairs.
class PairGate {
 public:
  PairGate(btDispatcher& dispatcher, btOverlappingPairCache& pair_cache, const btDispatcherInfo& info)
      : dispatcher_(dispatcher), pair_cache_(pair_cache), info_(info) {}

  bool admits(btCollisionObject& a, btCollisionObject& b) const;

  btDispatcher& dispatcher() const { return dispatcher_; }
  btOverlappingPairCache& pair_cache() const { return pair_cache_; }
  const btDispatcherInfo& info() const { return info_; }

 private:
  btDispatcher& dispatcher_;
  btOverlappingPairCache& pair_cache_;
  const btDispatcherInfo& info_;
};

}  // namespace softcd::bullet
