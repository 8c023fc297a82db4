#include "mesh_pairs.hpp"

#include <new>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionShapes/btConcaveShape.h"

namespace softcd::bullet {
namespace {

constexpr int kMeshTypes[] = {TRIANGLE_MESH_SHAPE_PROXYTYPE, SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE,
                              MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE, TERRAIN_SHAPE_PROXYTYPE};

bool is_taken(const btSoftBody& soft, const btCollisionObject& object) {
  using Flags = btSoftBody::fCollision;
  const int kind = soft.m_cfg.collisions & Flags::RVSmask;
  return (kind == Flags::SDF_RS || kind == Flags::SDF_RD) &&
         object.getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK;
}

class MeshPairAlgorithm : public AlgorithmInFront {
 public:
  MeshPairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* original,
                    std::shared_ptr<MeshPairs> pairs, bool is_swapped)
      : AlgorithmInFront(info, original), pairs_(std::move(pairs)), is_swapped_(is_swapped) {}

  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    const btCollisionObjectWrapper& soft = is_swapped_ ? *body1 : *body0;
    const btCollisionObjectWrapper& mesh = is_swapped_ ? *body0 : *body1;
    auto* body = const_cast<btSoftBody*>(btSoftBody::upcast(soft.getCollisionObject()));
    const btTransform& object = mesh.getCollisionObject()->getWorldTransform();
    const bool is_ours =
        pairs_->is_collecting() && is_taken(*body, *mesh.getCollisionObject()) &&
        pairs_->add({body, mesh.getCollisionObject(), static_cast<const btConcaveShape*>(mesh.getCollisionShape()),
                     object.inverseTimes(mesh.getWorldTransform()), mesh.m_index});
    if (!is_ours) AlgorithmInFront::processCollision(body0, body1, info, result);
  }

 private:
  std::shared_ptr<MeshPairs> pairs_;
  bool is_swapped_;
};

}  // namespace

MeshPairCreateFunc::MeshPairCreateFunc(btCollisionDispatcher& dispatcher, int type0, int type1,
                                       std::shared_ptr<MeshPairs> pairs)
    : pairs_(std::move(pairs)),
      is_swapped_(type1 == SOFTBODY_SHAPE_PROXYTYPE),
      registered_(dispatcher, type0, type1, *this) {}

btCollisionAlgorithm* MeshPairCreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                   const btCollisionObjectWrapper* body0,
                                                                   const btCollisionObjectWrapper* body1) {
  btCollisionAlgorithm* original = registered_.original().CreateCollisionAlgorithm(info, body0, body1);
  // Not from the dispatcher's pool, which does not look at sizes.
  void* memory = btAlignedAlloc(sizeof(MeshPairAlgorithm), 16);
  return new (memory) MeshPairAlgorithm(info, original, pairs_, is_swapped_);
}

CollectingMeshPairs::CollectingMeshPairs(btCollisionDispatcher& dispatcher, const std::shared_ptr<MeshPairs>& pairs)
    : pairs_(*pairs) {
  static_assert(std::size(kMeshTypes) == kMeshTypeCount);
  auto creator = creators_.begin();
  for (const int type : kMeshTypes) {
    (creator++)->emplace(dispatcher, SOFTBODY_SHAPE_PROXYTYPE, type, pairs);
    (creator++)->emplace(dispatcher, type, SOFTBODY_SHAPE_PROXYTYPE, pairs);
  }
  pairs_.set_collecting(true);
}

CollectingMeshPairs::~CollectingMeshPairs() {
  pairs_.set_collecting(false);
}

void process_natively(const MeshPair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  const btTransform& object = pair.object->getWorldTransform();
  const btTransform place = pair.child < 0 ? object : object * pair.shape_in_object;
  const btCollisionObjectWrapper soft(nullptr, pair.soft->getCollisionShape(), pair.soft,
                                      pair.soft->getWorldTransform(), -1, -1);
  const btCollisionObjectWrapper mesh(nullptr, pair.shape, pair.object, place, -1, pair.child);
  btCollisionAlgorithm* algorithm = dispatcher.findAlgorithm(&soft, &mesh, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  btManifoldResult result(&soft, &mesh);
  algorithm->processCollision(&soft, &mesh, info, &result);
  algorithm->~btCollisionAlgorithm();
  dispatcher.freeCollisionAlgorithm(algorithm);
}

void forget_rigid_algorithms(btOverlappingPairCache& pair_cache, btDispatcher& dispatcher) {
  btBroadphasePair* pairs = pair_cache.getOverlappingPairArrayPtr();
  for (int i = 0; i < pair_cache.getNumOverlappingPairs(); ++i) {
    const auto* a = btSoftBody::upcast(static_cast<const btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject));
    const auto* b = btSoftBody::upcast(static_cast<const btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject));
    if ((a == nullptr) != (b == nullptr)) pair_cache.cleanOverlappingPair(pairs[i], &dispatcher);
  }
}

}  // namespace softcd::bullet
