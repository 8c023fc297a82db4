#include "native/pair_order.hpp"

#include <limits>

#include "BulletCollision/BroadphaseCollision/btDispatcher.h"
#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

namespace softcd::bullet {

/// Follows btHashedOverlappingPairCache::processAllOverlappingPairs: pairs go by their place in the cache, or the
/// youngest first. A pair that an app's callback has removed from the cache is last.
std::pair<int, int> turn_of(const btCollisionObject& a, const btCollisionObject& b, const PairGate& gate) {
  constexpr std::pair<int, int> kLast(std::numeric_limits<int>::max(), 0);
  auto* proxy_a = const_cast<btBroadphaseProxy*>(a.getBroadphaseHandle());
  auto* proxy_b = const_cast<btBroadphaseProxy*>(b.getBroadphaseHandle());
  if (proxy_a == nullptr || proxy_b == nullptr) return kLast;
  if (gate.info().m_deterministicOverlappingPairs) {
    const auto [older, younger] = std::minmax({proxy_a->getUid(), proxy_b->getUid()});
    return {-older, -younger};
  }
  const btBroadphasePair* pair = gate.pair_cache().findPair(proxy_a, proxy_b);
  if (pair == nullptr) return kLast;
  return {static_cast<int>(pair - gate.pair_cache().getOverlappingPairArrayPtr()), 0};
}

}  // namespace softcd::bullet
