#include "pair_gate.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletSoftBody/btSoftSoftCollisionAlgorithm.h"

namespace softcd::bullet {
namespace {

// Where the pair being asked about is noted; null outside of PairGate::admits.
thread_local bool* recorded_pair = nullptr;

// Notes that the near callback let the pair through, instead of processing it.
class RecordingAlgorithm : public btSoftSoftCollisionAlgorithm {
 public:
  using btSoftSoftCollisionAlgorithm::btSoftSoftCollisionAlgorithm;

  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    if (recorded_pair != nullptr) {
      *recorded_pair = true;
    } else {
      btSoftSoftCollisionAlgorithm::processCollision(body0, body1, info, result);
    }
  }
};

struct RecordingCreateFunc : public btCollisionAlgorithmCreateFunc {
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* body0,
                                                 const btCollisionObjectWrapper* body1) override {
    void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(RecordingAlgorithm));
    return new (memory) RecordingAlgorithm(nullptr, info, body0, body1);
  }
};

class Recording {
 public:
  explicit Recording(bool& admitted) { recorded_pair = &admitted; }
  ~Recording() { recorded_pair = nullptr; }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
};

bool near_callback_admits(btCollisionDispatcher& dispatcher, btBroadphaseProxy& a, btBroadphaseProxy& b,
                          const btDispatcherInfo& info) {
  bool admitted = false;
  // The callback gets a pair of its own: one that the app's broad phase has not found (a fast body) must be
  // judged as well.
  btBroadphasePair pair(a, b);
  {
    const Recording recording(admitted);
    dispatcher.getNearCallback()(pair, dispatcher, info);
  }
  if (pair.m_algorithm != nullptr) {
    pair.m_algorithm->~btCollisionAlgorithm();
    dispatcher.freeCollisionAlgorithm(pair.m_algorithm);
  }
  return admitted;
}

}  // namespace

void install_pair_recorder(btCollisionDispatcher& dispatcher) {
  static RecordingCreateFunc create;
  dispatcher.registerCollisionCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, SOFTBODY_SHAPE_PROXYTYPE, &create);
}

bool PairGate::admits(btSoftBody& a, btSoftBody& b) const {
  btBroadphaseProxy* proxy_a = a.getBroadphaseHandle();
  btBroadphaseProxy* proxy_b = b.getBroadphaseHandle();
  if (proxy_a == nullptr || proxy_b == nullptr) return false;
  if (!pair_cache_.needsBroadphaseCollision(proxy_a, proxy_b)) return false;
  if (auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(&dispatcher_)) {
    return near_callback_admits(*dispatcher, *proxy_a, *proxy_b, info_);
  }
  return dispatcher_.needsCollision(&a, &b);
}

}  // namespace softcd::bullet
