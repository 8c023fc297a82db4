#include "rigid/mesh_pairs.hpp"

#include <algorithm>
#include <array>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionShapes/btConcaveShape.h"

namespace softcd::bullet {
namespace {

using Flags = btSoftBody::fCollision;

constexpr std::array<int, kMeshTypeCount> kMeshTypes = {
    TRIANGLE_MESH_SHAPE_PROXYTYPE, SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE, MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE,
    GIMPACT_SHAPE_PROXYTYPE, TERRAIN_SHAPE_PROXYTYPE};

bool take_over(MeshPairs& pairs, btSoftBody& soft, const btCollisionObjectWrapper& mesh) {
  const btCollisionObject* object = mesh.getCollisionObject();
  return takes_meshes_of(soft, *object) &&
         pairs.add({&soft, object, static_cast<const btConcaveShape*>(mesh.getCollisionShape()),
                    object->getWorldTransform().inverseTimes(mesh.getWorldTransform()), mesh.m_index});
}

}  // namespace

bool is_triangle_mesh(const btCollisionShape& shape) {
  return std::find(kMeshTypes.begin(), kMeshTypes.end(), shape.getShapeType()) != kMeshTypes.end();
}

bool takes_meshes_of(const btSoftBody& soft, const btCollisionObject& object) {
  const int kind = soft.m_cfg.collisions & Flags::RVSmask;
  const auto& disabled = soft.m_collisionDisabledObjects;
  return (kind == Flags::SDF_RS || kind == Flags::SDF_RD) &&
         object.getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK &&
         disabled.findLinearSearch(&object) == disabled.size();
}

CollectingMeshPairs::CollectingMeshPairs(btCollisionDispatcher& dispatcher, const std::shared_ptr<MeshPairs>& pairs)
    : CollectingPairs(pairs, take_over) {
  for (const int type : kMeshTypes) stand_before(dispatcher, type);
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
