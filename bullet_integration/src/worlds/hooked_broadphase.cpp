#include "worlds/hooked_broadphase.hpp"

#include <functional>

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "native/at_end.hpp"

namespace softcd::bullet {
void HookedPairCache::processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher,
                                                 const btDispatcherInfo& info) {
  const auto process = [&] { original_.processAllOverlappingPairs(callback, dispatcher, info); };
  hooks_.process_pairs(std::ref(process));  // allocates nothing
}

HookedBroadphase::HookedBroadphase(btBroadphaseInterface& original, BroadphaseHooks& hooks)
    : Broadphase(original),
      original_(original),
      hooks_(hooks),
      pair_cache_(*original.getOverlappingPairCache(), hooks) {}

void HookedBroadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  hooks_.before_removal(*static_cast<const btCollisionObject*>(proxy->m_clientObject));
  Broadphase::destroyProxy(proxy, dispatcher);
}

void HookedBroadphase::rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
                               const btVector3& aabb_min, const btVector3& aabb_max) {
  hooks_.before_ray_test();
  const AtEnd ends([this] { hooks_.after_ray_test(); });
  Broadphase::rayTest(from, to, callback, aabb_min, aabb_max);
}

void HookedBroadphase::calculateOverlappingPairs(btDispatcher* dispatcher) {
  hooks_.before_pairs();
  Broadphase::calculateOverlappingPairs(dispatcher);
}

}  // namespace softcd::bullet
