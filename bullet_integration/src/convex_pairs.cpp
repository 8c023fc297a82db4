#include "convex_pairs.hpp"

#include <new>

#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"

namespace softcd::bullet {
namespace {

bool is_looked_at(const btSoftBody& soft, const btCollisionObject& object) {
  using Flags = btSoftBody::fCollision;
  const int kind = soft.m_cfg.collisions & Flags::RVSmask;
  const int type = object.getInternalType();
  return (kind == Flags::SDF_RS || kind == Flags::SDF_RD) && object.hasContactResponse() &&
         (type == btCollisionObject::CO_RIGID_BODY || type == btCollisionObject::CO_FEATHERSTONE_LINK ||
          type == btCollisionObject::CO_COLLISION_OBJECT);
}

class ConvexPairAlgorithm : public AlgorithmInFront {
 public:
  ConvexPairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* original,
                      std::shared_ptr<ConvexPairs> pairs, bool is_swapped)
      : AlgorithmInFront(info, original), pairs_(std::move(pairs)), is_swapped_(is_swapped) {}

  /// A compound's children come with a parent: it was told of as a whole.
  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    const btCollisionObjectWrapper& soft = is_swapped_ ? *body1 : *body0;
    const btCollisionObjectWrapper& rigid = is_swapped_ ? *body0 : *body1;
    auto* body = const_cast<btSoftBody*>(btSoftBody::upcast(soft.getCollisionObject()));
    if (pairs_->is_collecting() && rigid.m_parent == nullptr && is_looked_at(*body, *rigid.getCollisionObject())) {
      pairs_->add({body, rigid.getCollisionObject()});
    }
    AlgorithmInFront::processCollision(body0, body1, info, result);
  }

 private:
  std::shared_ptr<ConvexPairs> pairs_;
  bool is_swapped_;
};

}  // namespace

ConvexPairCreateFunc::ConvexPairCreateFunc(btCollisionDispatcher& dispatcher, int type0, int type1,
                                           std::shared_ptr<ConvexPairs> pairs)
    : pairs_(std::move(pairs)),
      is_swapped_(type1 == SOFTBODY_SHAPE_PROXYTYPE),
      registered_(dispatcher, type0, type1, *this) {}

btCollisionAlgorithm* ConvexPairCreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                     const btCollisionObjectWrapper* body0,
                                                                     const btCollisionObjectWrapper* body1) {
  btCollisionAlgorithm* original = registered_.original().CreateCollisionAlgorithm(info, body0, body1);
  // Not from the dispatcher's pool, which does not look at sizes.
  void* memory = btAlignedAlloc(sizeof(ConvexPairAlgorithm), 16);
  return new (memory) ConvexPairAlgorithm(info, original, pairs_, is_swapped_);
}

CollectingConvexPairs::CollectingConvexPairs(btCollisionDispatcher& dispatcher,
                                             const std::shared_ptr<ConvexPairs>& pairs)
    : pairs_(*pairs) {
  auto creator = creators_.begin();
  const auto stand_before = [&](int type) {
    (creator++)->emplace(dispatcher, SOFTBODY_SHAPE_PROXYTYPE, type, pairs);
    (creator++)->emplace(dispatcher, type, SOFTBODY_SHAPE_PROXYTYPE, pairs);
  };
  for (int type = 0; type < kConvexTypeCount; ++type) stand_before(BOX_SHAPE_PROXYTYPE + type);
  stand_before(COMPOUND_SHAPE_PROXYTYPE);
  pairs_.set_collecting(true);
}

CollectingConvexPairs::~CollectingConvexPairs() {
  pairs_.set_collecting(false);
}

}  // namespace softcd::bullet
