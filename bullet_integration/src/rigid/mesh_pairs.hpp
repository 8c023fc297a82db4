#pragma once

#include <memory>

#include "BulletSoftBody/btSoftBody.h"
#include "rigid/collecting_pairs.hpp"

class btConcaveShape;
struct btDispatcherInfo;
class btOverlappingPairCache;

namespace softcd::bullet {

/// A soft body and a rigid triangle mesh that Bullet wants to collide: their boxes overlap and every filter agrees.
struct MeshPair {
  btSoftBody* soft;
  const btCollisionObject* object;
  const btConcaveShape* shape;
  btTransform shape_in_object;  ///< a compound's child is not at its object's origin
  int child;                    ///< which of the object's children; -1 where the shape is the object's own
};

using MeshPairs = DispatchedPairs<MeshPair>;

constexpr std::size_t kMeshTypeCount = 5;

/// btBvhTriangleMeshShape, its scaled and multi-material forms, GImpact and btHeightfieldTerrainShape.
bool is_triangle_mesh(const btCollisionShape& shape);
/// Whether softcd looks after the soft body (which has SDF_RS or SDF_RD) and the object's meshes: not after those of
/// multibody links, nor of what the body is anchored to without colliding with it.
bool takes_meshes_of(const btSoftBody& soft, const btCollisionObject& object);

/// Collects pairs of soft bodies and triangle meshes that softcd looks after, which Bullet does not process then.
class CollectingMeshPairs : public CollectingPairs<MeshPair, kMeshTypeCount> {
 public:
  CollectingMeshPairs(btCollisionDispatcher& dispatcher, const std::shared_ptr<MeshPairs>& pairs);
};

/// Bullet's own processing of a collected pair, or the app's where that has registered an algorithm. Not while others
/// are collected.
void process_natively(const MeshPair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info);

/// Frees the algorithms of pairs of soft bodies and others: the next dispatch makes new ones.
void forget_rigid_algorithms(btOverlappingPairCache& pair_cache, btDispatcher& dispatcher);

}  // namespace softcd::bullet
