#pragma once

#include <functional>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "softcd/bullet/broadphase.hpp"

namespace softcd::bullet {

/// The calls of a world to its broad phase during a step.
class BroadphaseHooks {
 public:
  /// Processes all pairs, as the dispatcher has asked for.
  using Processing = std::function<void()>;

  /// Called when boxes are up to date.
  virtual void before_pairs() = 0;
  /// Called instead of the processing.
  virtual void process_pairs(const Processing& process_natively) = 0;
  virtual void before_removal(const btCollisionObject& object) = 0;
  /// Called before and after a ray test of the world.
  virtual void before_ray_test() = 0;
  virtual void after_ray_test() noexcept = 0;

 protected:
  ~BroadphaseHooks() = default;
};

/// A broad phase's pair cache that calls hooks during a dispatch. Passes everything else to the original.
class HookedPairCache : public btOverlappingPairCache {
 public:
  /// Both outlive it.
  HookedPairCache(btOverlappingPairCache& original, BroadphaseHooks& hooks) : original_(original), hooks_(hooks) {}

  void processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher,
                                  const btDispatcherInfo& info) override;

  void processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher) override {
    original_.processAllOverlappingPairs(callback, dispatcher);
  }
  btBroadphasePair* getOverlappingPairArrayPtr() override { return original_.getOverlappingPairArrayPtr(); }
  const btBroadphasePair* getOverlappingPairArrayPtr() const override { return original_.getOverlappingPairArrayPtr(); }
  btBroadphasePairArray& getOverlappingPairArray() override { return original_.getOverlappingPairArray(); }
  void cleanOverlappingPair(btBroadphasePair& pair, btDispatcher* dispatcher) override {
    original_.cleanOverlappingPair(pair, dispatcher);
  }
  int getNumOverlappingPairs() const override { return original_.getNumOverlappingPairs(); }
  bool needsBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    return original_.needsBroadphaseCollision(a, b);
  }
  btOverlapFilterCallback* getOverlapFilterCallback() override { return original_.getOverlapFilterCallback(); }
  void cleanProxyFromPairs(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override {
    original_.cleanProxyFromPairs(proxy, dispatcher);
  }
  void setOverlapFilterCallback(btOverlapFilterCallback* callback) override {
    original_.setOverlapFilterCallback(callback);
  }
  btBroadphasePair* findPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override { return original_.findPair(a, b); }
  bool hasDeferredRemoval() override { return original_.hasDeferredRemoval(); }
  void setInternalGhostPairCallback(btOverlappingPairCallback* callback) override {
    original_.setInternalGhostPairCallback(callback);
  }
  void sortOverlappingPairs(btDispatcher* dispatcher) override { original_.sortOverlappingPairs(dispatcher); }
  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override {
    return original_.addOverlappingPair(a, b);
  }
  void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b, btDispatcher* dispatcher) override {
    return original_.removeOverlappingPair(a, b, dispatcher);
  }
  void removeOverlappingPairsContainingProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override {
    original_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
  }

 private:
  btOverlappingPairCache& original_;
  BroadphaseHooks& hooks_;
};

/// A world's broad phase that calls hooks. Passes everything else to the original, which also owns the proxies.
class HookedBroadphase : public Broadphase {
 public:
  /// Both outlive it.
  HookedBroadphase(btBroadphaseInterface& original, BroadphaseHooks& hooks);

  btBroadphaseInterface& original() const { return original_; }
  BroadphaseHooks& hooks() const { return hooks_; }

  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  void rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
               const btVector3& aabb_min = btVector3(0, 0, 0), const btVector3& aabb_max = btVector3(0, 0, 0)) override;
  void calculateOverlappingPairs(btDispatcher* dispatcher) override;
  btOverlappingPairCache* getOverlappingPairCache() override { return &pair_cache_; }
  const btOverlappingPairCache* getOverlappingPairCache() const override { return &pair_cache_; }

 private:
  btBroadphaseInterface& original_;
  BroadphaseHooks& hooks_;
  HookedPairCache pair_cache_;
};

}  // namespace softcd::bullet
