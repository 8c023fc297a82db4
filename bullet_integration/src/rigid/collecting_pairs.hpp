#pragma once

#include <array>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletSoftBody/btSoftBody.h"
#include "native/registered_algorithm.hpp"
#include "rigid/dispatched_pairs.hpp"

namespace softcd::bullet {

/// Adds to `pairs` what a soft body and another object are to softcd. True where Bullet is not to process them.
template <class Pair>
using TakePair = bool (*)(DispatchedPairs<Pair>& pairs, btSoftBody& soft, const btCollisionObjectWrapper& other);

/// Of one pair, for as long as Bullet keeps it. Hands it over while pairs are collected.
template <class Pair>
class PairAlgorithm : public AlgorithmInFront {
 public:
  PairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* original,
                std::shared_ptr<DispatchedPairs<Pair>> pairs, TakePair<Pair> take, bool is_swapped)
      : AlgorithmInFront(info, original), pairs_(std::move(pairs)), take_(take), is_swapped_(is_swapped) {}

  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    const btCollisionObjectWrapper& soft = is_swapped_ ? *body1 : *body0;
    const btCollisionObjectWrapper& other = is_swapped_ ? *body0 : *body1;
    auto* body = const_cast<btSoftBody*>(btSoftBody::upcast(soft.getCollisionObject()));
    if (pairs_->is_collecting() && take_(*pairs_, *body, other)) return;
    AlgorithmInFront::processCollision(body0, body1, info, result);
  }

 private:
  std::shared_ptr<DispatchedPairs<Pair>> pairs_;
  TakePair<Pair> take_;
  bool is_swapped_;
};

/// Makes PairAlgorithms in front of what would have been made without it.
template <class Pair>
class PairCreateFunc : public btCollisionAlgorithmCreateFunc {
 public:
  PairCreateFunc(btCollisionDispatcher& dispatcher, int type0, int type1, std::shared_ptr<DispatchedPairs<Pair>> pairs,
                 TakePair<Pair> take)
      : pairs_(std::move(pairs)),
        take_(take),
        is_swapped_(type1 == SOFTBODY_SHAPE_PROXYTYPE),
        registered_(dispatcher, type0, type1, *this) {}

  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* body0,
                                                 const btCollisionObjectWrapper* body1) override {
    btCollisionAlgorithm* original = registered_.original().CreateCollisionAlgorithm(info, body0, body1);
    // Not from the dispatcher's pool, which does not look at sizes.
    void* memory = btAlignedAlloc(sizeof(PairAlgorithm<Pair>), 16);
    return new (memory) PairAlgorithm<Pair>(info, original, pairs_, take_, is_swapped_);
  }

 private:
  std::shared_ptr<DispatchedPairs<Pair>> pairs_;
  TakePair<Pair> take_;
  bool is_swapped_;
  RegisteredAlgorithm registered_;
};

/// Between construction and destruction, what `dispatcher` processes of pairs of soft bodies and shapes of given types
/// goes to `take`, in pairs whose algorithm is made now or was made in such a time before. Allocates nothing.
template <class Pair, std::size_t kTypeCount>
class CollectingPairs {
 public:
  CollectingPairs(const CollectingPairs&) = delete;
  CollectingPairs& operator=(const CollectingPairs&) = delete;

 protected:
  CollectingPairs(std::shared_ptr<DispatchedPairs<Pair>> pairs, TakePair<Pair> take)
      : pairs_(std::move(pairs)), take_(take) {
    pairs_->set_collecting(true);
  }
  ~CollectingPairs() { pairs_->set_collecting(false); }

  /// Of kTypeCount types.
  void stand_before(btCollisionDispatcher& dispatcher, int type) {
    creators_[creator_count_++].emplace(dispatcher, SOFTBODY_SHAPE_PROXYTYPE, type, pairs_, take_);
    creators_[creator_count_++].emplace(dispatcher, type, SOFTBODY_SHAPE_PROXYTYPE, pairs_, take_);
  }

 private:
  std::shared_ptr<DispatchedPairs<Pair>> pairs_;
  TakePair<Pair> take_;
  std::array<std::optional<PairCreateFunc<Pair>>, 2 * kTypeCount> creators_;
  std::size_t creator_count_ = 0;
};

}  // namespace softcd::bullet
