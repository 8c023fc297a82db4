#include "mesh_pairs.hpp"

#include <unordered_map>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "BulletSoftBody/btSoftBodyConcaveCollisionAlgorithm.h"

namespace softcd::bullet {
namespace {

constexpr int kMeshTypes[] = {TRIANGLE_MESH_SHAPE_PROXYTYPE, SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE,
                              MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE, TERRAIN_SHAPE_PROXYTYPE};

/// Whose pairs are being collected. Algorithms know nothing but their dispatcher.
class Collectors {
 public:
  static Collectors& instance() {
    static Collectors collectors;
    return collectors;
  }

  void start(const btDispatcher* dispatcher, MeshPairs& pairs) {
    const std::lock_guard lock(mutex_);
    collectors_[dispatcher] = &pairs;
  }
  void stop(const btDispatcher* dispatcher) {
    const std::lock_guard lock(mutex_);
    collectors_.erase(dispatcher);
  }
  MeshPairs* find(const btDispatcher* dispatcher) {
    const std::lock_guard lock(mutex_);
    const auto found = collectors_.find(dispatcher);
    return found != collectors_.end() ? found->second : nullptr;
  }

 private:
  std::mutex mutex_;
  std::unordered_map<const btDispatcher*, MeshPairs*> collectors_;
};

bool is_taken(const btSoftBody& soft, const btCollisionObject& object) {
  using Flags = btSoftBody::fCollision;
  const int kind = soft.m_cfg.collisions & Flags::RVSmask;
  return (kind == Flags::SDF_RS || kind == Flags::SDF_RD) &&
         object.getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK;
}

template <bool kSwapped>
class MeshPairAlgorithm : public btSoftBodyConcaveCollisionAlgorithm {
 public:
  MeshPairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* body0,
                    const btCollisionObjectWrapper* body1)
      : btSoftBodyConcaveCollisionAlgorithm(info, body0, body1, kSwapped) {}

  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    const btCollisionObjectWrapper& soft = kSwapped ? *body1 : *body0;
    const btCollisionObjectWrapper& mesh = kSwapped ? *body0 : *body1;
    auto* body = const_cast<btSoftBody*>(btSoftBody::upcast(soft.getCollisionObject()));
    MeshPairs* pairs = Collectors::instance().find(m_dispatcher);
    if (pairs == nullptr || !is_taken(*body, *mesh.getCollisionObject())) {
      btSoftBodyConcaveCollisionAlgorithm::processCollision(body0, body1, info, result);
      return;
    }
    const btTransform& object = mesh.getCollisionObject()->getWorldTransform();
    pairs->add({body, mesh.getCollisionObject(), static_cast<const btConcaveShape*>(mesh.getCollisionShape()),
                object.inverseTimes(mesh.getWorldTransform()), mesh.m_index});
  }
};

template <bool kSwapped>
struct MeshPairCreateFunc : public btCollisionAlgorithmCreateFunc {
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* body0,
                                                 const btCollisionObjectWrapper* body1) override {
    // Not from the dispatcher's pool, which does not look at sizes.
    void* memory = btAlignedAlloc(sizeof(MeshPairAlgorithm<kSwapped>), 16);
    return new (memory) MeshPairAlgorithm<kSwapped>(info, body0, body1);
  }
};

}  // namespace

CollectingMeshPairs::CollectingMeshPairs(btCollisionDispatcher& dispatcher, MeshPairs& pairs)
    : dispatcher_(&dispatcher) {
  static MeshPairCreateFunc<false> create;
  static MeshPairCreateFunc<true> create_swapped;
  // Every time: registering GImpact's own algorithm replaces what stands here.
  for (const int type : kMeshTypes) {
    dispatcher.registerCollisionCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, type, &create);
    dispatcher.registerCollisionCreateFunc(type, SOFTBODY_SHAPE_PROXYTYPE, &create_swapped);
  }
  Collectors::instance().start(dispatcher_, pairs);
}

CollectingMeshPairs::~CollectingMeshPairs() {
  Collectors::instance().stop(dispatcher_);
}

}  // namespace softcd::bullet
