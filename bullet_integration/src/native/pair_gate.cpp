#include "native/pair_gate.hpp"

#include <optional>

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "native/registered_algorithm.hpp"

namespace softcd::bullet {
namespace {

// Records that the near callback admits a pair, instead of processing the pair.
class RecordingAlgorithm : public btCollisionAlgorithm {
 public:
  RecordingAlgorithm(const btCollisionAlgorithmConstructionInfo& info, bool& admitted)
      : btCollisionAlgorithm(info), admitted_(admitted) {}

  void processCollision(const btCollisionObjectWrapper* /*body0*/, const btCollisionObjectWrapper* /*body1*/,
                        const btDispatcherInfo& /*info*/, btManifoldResult* /*result*/) override {
    admitted_ = true;
  }
  btScalar calculateTimeOfImpact(btCollisionObject* /*body0*/, btCollisionObject* /*body1*/,
                                 const btDispatcherInfo& /*info*/, btManifoldResult* /*result*/) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& /*manifolds*/) override {}

 private:
  bool& admitted_;
};

struct RecordingCreateFunc : public btCollisionAlgorithmCreateFunc {
  bool admitted = false;

  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* /*body0*/,
                                                 const btCollisionObjectWrapper* /*body1*/) override {
    void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(RecordingAlgorithm));
    return new (memory) RecordingAlgorithm(info, admitted);
  }
};

/// A pair made for the callback only: it must also judge pairs that the app's broad phase has not found (fast bodies).
class AskedPair {
 public:
  AskedPair(btDispatcher& dispatcher, btBroadphaseProxy& a, btBroadphaseProxy& b)
      : pair(a, b), dispatcher_(dispatcher) {}
  ~AskedPair() {
    if (pair.m_algorithm == nullptr) return;
    pair.m_algorithm->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(pair.m_algorithm);
  }
  AskedPair(const AskedPair&) = delete;
  AskedPair& operator=(const AskedPair&) = delete;

  btBroadphasePair pair;

 private:
  btDispatcher& dispatcher_;
};

bool near_callback_admits(btCollisionDispatcher& dispatcher, const btCollisionObject& a, const btCollisionObject& b,
                          const btDispatcherInfo& info) {
  RecordingCreateFunc create;
  const int type_a = a.getCollisionShape()->getShapeType();
  const int type_b = b.getCollisionShape()->getShapeType();
  const RegisteredAlgorithm recorder(dispatcher, type_a, type_b, create);
  std::optional<RegisteredAlgorithm> turned;
  if (type_a != type_b) turned.emplace(dispatcher, type_b, type_a, create);
  AskedPair asked(dispatcher, const_cast<btBroadphaseProxy&>(*a.getBroadphaseHandle()),
                  const_cast<btBroadphaseProxy&>(*b.getBroadphaseHandle()));
  dispatcher.getNearCallback()(asked.pair, dispatcher, info);
  return create.admitted;
}

}  // namespace

bool PairGate::admits(btCollisionObject& a, btCollisionObject& b) const {
  btBroadphaseProxy* proxy_a = a.getBroadphaseHandle();
  btBroadphaseProxy* proxy_b = b.getBroadphaseHandle();
  if (proxy_a == nullptr || proxy_b == nullptr) return false;
  if (!pair_cache_.needsBroadphaseCollision(proxy_a, proxy_b)) return false;
  if (auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(&dispatcher_)) {
    return near_callback_admits(*dispatcher, a, b, info_);
  }
  return dispatcher_.needsCollision(&a, &b);
}

}  // namespace softcd::bullet
