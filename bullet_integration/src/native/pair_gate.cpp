#include "native/pair_gate.hpp"

#include <utility>

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "native/at_end.hpp"
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

bool near_callback_admits(btCollisionDispatcher& dispatcher, const btCollisionObject& a, const btCollisionObject& b,
                          const btDispatcherInfo& info) {
  RecordingCreateFunc create;
  const int type_a = a.getCollisionShape()->getShapeType();
  const int type_b = b.getCollisionShape()->getShapeType();
  // Restores an entry, unless it has changed again.
  const auto record = [&](int type0, int type1) {
    btCollisionAlgorithmCreateFunc*& entry = registered_algorithm(dispatcher, type0, type1);
    return AtEnd([&entry, &create, original = std::exchange(entry, &create)] {
      if (entry == &create) entry = original;
    });
  };
  const auto recorded = record(type_a, type_b);
  const auto recorded_swapped = record(type_b, type_a);
  // A pair made for the callback only: it must also judge pairs that the app's broad phase has not found (fast bodies).
  btBroadphasePair pair(const_cast<btBroadphaseProxy&>(*a.getBroadphaseHandle()),
                        const_cast<btBroadphaseProxy&>(*b.getBroadphaseHandle()));
  const AtEnd judged([&] {
    if (pair.m_algorithm == nullptr) return;
    pair.m_algorithm->~btCollisionAlgorithm();
    dispatcher.freeCollisionAlgorithm(pair.m_algorithm);
  });
  dispatcher.getNearCallback()(pair, dispatcher, info);
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
