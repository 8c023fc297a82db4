#pragma once

#include <array>
#include <memory>
#include <optional>

#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"
#include "BulletSoftBody/btSoftBody.h"
#include "dispatched_pairs.hpp"
#include "registered_algorithm.hpp"

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

/// Makes algorithms that hand pairs to MeshPairs while these collect, and else, and what is not softcd's anyway, to the
/// algorithm that would have stood there without us. Bullet keeps an algorithm as long as its pair.
class MeshPairCreateFunc : public btCollisionAlgorithmCreateFunc {
 public:
  MeshPairCreateFunc(btCollisionDispatcher& dispatcher, int type0, int type1, std::shared_ptr<MeshPairs> pairs);

  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* body0,
                                                 const btCollisionObjectWrapper* body1) override;

 private:
  std::shared_ptr<MeshPairs> pairs_;
  bool is_swapped_;
  RegisteredAlgorithm registered_;
};

/// Between construction and destruction, what `dispatcher` finds of pairs of soft bodies (with SDF_RS or SDF_RD) and
/// triangle meshes (btBvhTriangleMeshShape, its scaled and multi-material forms, GImpact, btHeightfieldTerrainShape) of
/// rigid bodies goes to `pairs` and is not processed by Bullet, in pairs whose algorithm is made now or was made in
/// such a time before. Meshes of multibody links stay Bullet's.
class CollectingMeshPairs {
 public:
  CollectingMeshPairs(btCollisionDispatcher& dispatcher, const std::shared_ptr<MeshPairs>& pairs);
  ~CollectingMeshPairs();
  CollectingMeshPairs(const CollectingMeshPairs&) = delete;
  CollectingMeshPairs& operator=(const CollectingMeshPairs&) = delete;

 private:
  static constexpr std::size_t kMeshTypeCount = 5;

  MeshPairs& pairs_;
  std::array<std::optional<MeshPairCreateFunc>, 2 * kMeshTypeCount> creators_;
};

/// Bullet's own processing of a collected pair, or the app's where that has registered an algorithm. Not while others
/// are collected.
void process_natively(const MeshPair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info);

/// Frees the algorithms of pairs of soft bodies and others: the next dispatch makes new ones.
void forget_rigid_algorithms(btOverlappingPairCache& pair_cache, btDispatcher& dispatcher);

}  // namespace softcd::bullet
