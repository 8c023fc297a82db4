#include "rigid/rigid_pairs.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "native/registered_algorithm.hpp"

namespace softcd::bullet {
namespace {

using Flags = btSoftBody::fCollision;

constexpr int kMeshTypes[] = {TRIANGLE_MESH_SHAPE_PROXYTYPE, SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE,
                              MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE, TERRAIN_SHAPE_PROXYTYPE};

bool meets_rigid_bodies(const btSoftBody& soft) {
  const int kind = soft.m_cfg.collisions & Flags::RVSmask;
  return kind == Flags::SDF_RS || kind == Flags::SDF_RD;
}

/// Admits links of multibodies, but no objects without response to contacts.
bool takes_convex_shapes_of(const btSoftBody& soft, const btCollisionObject& object) {
  const int type = object.getInternalType();
  return meets_rigid_bodies(soft) && object.hasContactResponse() &&
         (type == btCollisionObject::CO_RIGID_BODY || type == btCollisionObject::CO_FEATHERSTONE_LINK ||
          type == btCollisionObject::CO_COLLISION_OBJECT);
}

/// Returns the place of a pair in the order of btHashedOverlappingPairCache::processAllOverlappingPairs: pairs go by
/// their place in the cache, or the youngest first. A pair that an app's callback has removed from the cache is last.
std::pair<int, int> turn_of(const RigidPair& pair, const PairGate& gate) {
  constexpr std::pair<int, int> kLast(std::numeric_limits<int>::max(), 0);
  auto* proxy_a = pair.soft->getBroadphaseHandle();
  auto* proxy_b = const_cast<btBroadphaseProxy*>(pair.object->getBroadphaseHandle());
  if (proxy_a == nullptr || proxy_b == nullptr) return kLast;
  if (gate.info().m_deterministicOverlappingPairs) {
    const auto [older, younger] = std::minmax({proxy_a->getUid(), proxy_b->getUid()});
    return {-older, -younger};
  }
  const btBroadphasePair* cached = gate.pair_cache().findPair(proxy_a, proxy_b);
  if (cached == nullptr) return kLast;
  return {static_cast<int>(cached - gate.pair_cache().getOverlappingPairArrayPtr()), 0};
}

/// Replaces another algorithm of a pair for as long as Bullet keeps it. Calls that algorithm for pairs that softcd does
/// not take.
class AlgorithmInFront : public btCollisionAlgorithm {
 public:
  /// Owns `original`.
  AlgorithmInFront(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* original,
                   std::shared_ptr<RigidPairs> pairs, bool is_swapped)
      : btCollisionAlgorithm(info), original_(original), pairs_(std::move(pairs)), is_swapped_(is_swapped) {}
  ~AlgorithmInFront() override {
    original_->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(original_);
  }
  AlgorithmInFront(const AlgorithmInFront&) = delete;
  AlgorithmInFront& operator=(const AlgorithmInFront&) = delete;

  void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    const btCollisionObjectWrapper& soft = is_swapped_ ? *body1 : *body0;
    const btCollisionObjectWrapper& other = is_swapped_ ? *body0 : *body1;
    auto* body = const_cast<btSoftBody*>(btSoftBody::upcast(soft.getCollisionObject()));
    if (!pairs_->take(*body, other)) original_->processCollision(body0, body1, info, result);
  }
  btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1, const btDispatcherInfo& info,
                                 btManifoldResult* result) override {
    return original_->calculateTimeOfImpact(body0, body1, info, result);
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override { original_->getAllContactManifolds(manifolds); }

 private:
  btCollisionAlgorithm* original_;
  std::shared_ptr<RigidPairs> pairs_;
  bool is_swapped_;
};

}  // namespace

bool is_triangle_mesh(const btCollisionShape& shape) {
  return std::find(std::begin(kMeshTypes), std::end(kMeshTypes), shape.getShapeType()) != std::end(kMeshTypes);
}

bool takes_meshes_of(const btSoftBody& soft, const btCollisionObject& object) {
  const auto& disabled = soft.m_collisionDisabledObjects;
  return meets_rigid_bodies(soft) && object.getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK &&
         disabled.findLinearSearch(&object) == disabled.size();
}

bool RigidPairs::take(btSoftBody& soft, const btCollisionObjectWrapper& other) noexcept {
  const bool is_mesh = is_triangle_mesh(*other.getCollisionShape());
  const RigidPairKind kind = is_mesh ? RigidPairKind::mesh : RigidPairKind::convex;
  if (!list(kind).is_collecting) return false;
  const btCollisionObject& object = *other.getCollisionObject();
  const RigidPair pair = {&soft, &object, other.getCollisionShape(),
                          object.getWorldTransform().inverseTimes(other.getWorldTransform()), other.m_index};
  if (is_mesh) return takes_meshes_of(soft, object) && add(kind, pair);
  // A compound's child has a parent. The compound itself was collected as a whole.
  if (other.m_parent == nullptr && takes_convex_shapes_of(soft, object)) add(kind, pair);
  return false;
}

bool RigidPairs::add(RigidPairKind kind, const RigidPair& pair) noexcept {
  const std::lock_guard lock(mutex_);
  Collected& collected = list(kind).collected;
  try {
    collected.pairs.push_back(pair);
    return true;
  } catch (const std::bad_alloc&) {
    collected.is_complete = false;
    return false;
  }
}

RigidPairs::Collected RigidPairs::take_collected(RigidPairKind kind, const PairGate& gate) {
  Collected collected = std::exchange(list(kind).collected, {});
  const auto comes_before = [&](const RigidPair& a, const RigidPair& b) { return turn_of(a, gate) < turn_of(b, gate); };
  if (!std::is_sorted(collected.pairs.begin(), collected.pairs.end(), comes_before)) {
    std::stable_sort(collected.pairs.begin(), collected.pairs.end(), comes_before);
  }
  return collected;
}

btCollisionAlgorithmCreateFunc*& CollectingRigidPairs::CreateFunc::entry(btCollisionDispatcher& dispatcher,
                                                                         int type) const {
  return is_swapped_ ? registered_algorithm(dispatcher, type, SOFTBODY_SHAPE_PROXYTYPE)
                     : registered_algorithm(dispatcher, SOFTBODY_SHAPE_PROXYTYPE, type);
}

void CollectingRigidPairs::CreateFunc::replace(btCollisionDispatcher& dispatcher, int type) {
  originals_[static_cast<std::size_t>(type)] = std::exchange(entry(dispatcher, type), this);
}

/// An entry that has changed again stays.
void CollectingRigidPairs::CreateFunc::give_back(btCollisionDispatcher& dispatcher, int type) {
  btCollisionAlgorithmCreateFunc*& now = entry(dispatcher, type);
  if (now == this) now = originals_[static_cast<std::size_t>(type)];
}

btCollisionAlgorithm* CollectingRigidPairs::CreateFunc::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* body0,
    const btCollisionObjectWrapper* body1) {
  const int type = (is_swapped_ ? body0 : body1)->getCollisionShape()->getShapeType();
  btCollisionAlgorithm* const original =
      originals_[static_cast<std::size_t>(type)]->CreateCollisionAlgorithm(info, body0, body1);
  // Does not use the dispatcher's pool, which ignores sizes.
  void* memory = btAlignedAlloc(sizeof(AlgorithmInFront), 16);
  return new (memory) AlgorithmInFront(info, original, pairs_, is_swapped_);
}

CollectingRigidPairs::CollectingRigidPairs(btCollisionDispatcher& dispatcher, std::shared_ptr<RigidPairs> pairs,
                                           bool meshes, bool convex)
    : dispatcher_(dispatcher),
      pairs_(std::move(pairs)),
      meshes_(meshes),
      convex_(convex),
      soft_first_(pairs_, /*is_swapped=*/false),
      soft_second_(pairs_, /*is_swapped=*/true) {
  pairs_->set_collecting(RigidPairKind::mesh, meshes);
  pairs_->set_collecting(RigidPairKind::convex, convex);
  for_each_type([this](int type) {
    soft_first_.replace(dispatcher_, type);
    soft_second_.replace(dispatcher_, type);
  });
}

CollectingRigidPairs::~CollectingRigidPairs() {
  pairs_->set_collecting(RigidPairKind::mesh, false);
  pairs_->set_collecting(RigidPairKind::convex, false);
  for_each_type([this](int type) {
    soft_first_.give_back(dispatcher_, type);
    soft_second_.give_back(dispatcher_, type);
  });
}

/// Calls visit(type) for the types of the shapes whose pairs are collected.
template <class Visit>
void CollectingRigidPairs::for_each_type(Visit visit) const {
  if (meshes_) std::for_each(std::begin(kMeshTypes), std::end(kMeshTypes), visit);
  if (!convex_) return;
  for (int type = BOX_SHAPE_PROXYTYPE; type < CONCAVE_SHAPES_START_HERE; ++type) visit(type);
  visit(COMPOUND_SHAPE_PROXYTYPE);
}

void process_natively(const RigidPair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
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
  for_each_pair_with_rigid(pair_cache, [&](btBroadphasePair& pair, const btSoftBody& /*soft*/) {
    pair_cache.cleanOverlappingPair(pair, &dispatcher);
  });
}

}  // namespace softcd::bullet
