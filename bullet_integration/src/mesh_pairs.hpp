#pragma once

#include <mutex>
#include <utility>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"

class btCollisionDispatcher;
class btConcaveShape;

namespace softcd::bullet {

/// A soft body and a rigid triangle mesh that Bullet wants to collide: their boxes overlap and every filter agrees.
struct MeshPair {
  btSoftBody* soft;
  const btCollisionObject* object;
  const btConcaveShape* shape;
  btTransform shape_in_object;  ///< a compound's child is not at its object's origin
  int child;                    ///< which of the object's children; -1 where the shape is the object's own
};

/// The pairs that come up while Bullet dispatches. Thread-safe: some dispatchers call from several threads.
class MeshPairs {
 public:
  void add(const MeshPair& pair) {
    const std::lock_guard lock(mutex_);
    pairs_.push_back(pair);
  }
  std::vector<MeshPair> take() { return std::exchange(pairs_, {}); }

 private:
  std::mutex mutex_;
  std::vector<MeshPair> pairs_;
};

/// Between construction and destruction, what `dispatcher` finds of pairs of soft bodies (with SDF_RS or SDF_RD) and
/// triangle meshes (btBvhTriangleMeshShape, its scaled and multi-material forms, GImpact, btHeightfieldTerrainShape) of
/// rigid bodies goes to `pairs` and is not processed by Bullet. Meshes of multibody links stay Bullet's. Outside of it
/// Bullet processes all of them. An app's own algorithm for such pairs is replaced, once, for good.
class CollectingMeshPairs {
 public:
  CollectingMeshPairs(btCollisionDispatcher& dispatcher, MeshPairs& pairs);
  ~CollectingMeshPairs();
  CollectingMeshPairs(const CollectingMeshPairs&) = delete;
  CollectingMeshPairs& operator=(const CollectingMeshPairs&) = delete;

 private:
  const btDispatcher* dispatcher_;
};

}  // namespace softcd::bullet
