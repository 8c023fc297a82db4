#pragma once

#include <atomic>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"
#include "BulletCollision/BroadphaseCollision/btDispatcher.h"

namespace softcd::bullet {

/// The pairs that come up while Bullet dispatches. Thread-safe: some dispatchers call from several threads.
template <class Pair>
class DispatchedPairs {
 public:
  bool is_collecting() const { return is_collecting_; }
  void set_collecting(bool is_collecting) { is_collecting_ = is_collecting; }
  /// False where memory does not suffice: the pair is not among those collected, which are not complete then.
  bool add(const Pair& pair) noexcept {
    const std::lock_guard lock(mutex_);
    try {
      collected_.pairs.push_back(pair);
      return true;
    } catch (const std::bad_alloc&) {
      collected_.is_complete = false;
      return false;
    }
  }

  struct Collected {
    std::vector<Pair> pairs;
    bool is_complete = true;
  };
  /// Those since the last call, in the order in which threads came upon them: see PairOrder.
  Collected take() { return std::exchange(collected_, {}); }

 private:
  std::mutex mutex_;
  std::atomic<bool> is_collecting_ = false;
  Collected collected_;
};

/// Stands where another algorithm would have stood, and can do whatever that does.
class AlgorithmInFront : public btCollisionAlgorithm {
 public:
  /// Owns `original`.
  AlgorithmInFront(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* original)
      : btCollisionAlgorithm(info), original_(original) {}
  ~AlgorithmInFront() override {
    original_->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(original_);
  }
  AlgorithmInFront(const AlgorithmInFront&) = delete;
  AlgorithmInFront& operator=(const AlgorithmInFront&) = delete;

  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    original_->processCollision(body0, body1, info, result);
  }
  btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1, const btDispatcherInfo& info,
                                 btManifoldResult* result) override {
    return original_->calculateTimeOfImpact(body0, body1, info, result);
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override { original_->getAllContactManifolds(manifolds); }

 private:
  btCollisionAlgorithm* original_;
};

}  // namespace softcd::bullet
