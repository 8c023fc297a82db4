#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"
#include "BulletSoftBody/btSoftBody.h"
#include "native/registered_algorithm.hpp"

struct btDispatcherInfo;
class btOverlappingPairCache;

namespace softcd::bullet {

/// A soft body and a rigid shape that Bullet wants to collide: their boxes overlap and every filter agrees.
struct RigidPair {
  btSoftBody* soft;
  const btCollisionObject* object;
  const btCollisionShape* shape;  ///< a triangle mesh; or the object's whole shape, convex or a compound
  btTransform shape_in_object;    ///< a compound's child is not at its object's origin
  int child;                      ///< which of the object's children; -1 where the shape is the object's own
};

/// The kind of contacts that softcd detects in a pair.
enum class RigidPairKind : std::uint8_t {
  mesh,    ///< with a triangle mesh; Bullet does not process what is collected
  convex,  ///< with an object that is convex or a compound; Bullet processes it as ever
};

/// Whether the shape is a btBvhTriangleMeshShape, one of its scaled and multi-material forms, GImpact or a
/// btHeightfieldTerrainShape.
bool is_triangle_mesh(const btCollisionShape& shape);
/// Whether softcd looks after the soft body (which has SDF_RS or SDF_RD) and the object's meshes: not after those of
/// multibody links, nor of what the body is anchored to without colliding with it.
bool takes_meshes_of(const btSoftBody& soft, const btCollisionObject& object);

/// The pairs that come up while Bullet dispatches. Thread-safe: some dispatchers call from several threads.
class RigidPairs {
 public:
  struct Collected {
    std::vector<RigidPair> pairs;
    bool is_complete = true;  ///< false where memory did not suffice
  };

  void set_collecting(RigidPairKind kind, bool is_collecting) { list(kind).is_collecting = is_collecting; }
  /// Adds the pair where its kind is collected and softcd looks after it. True where Bullet is not to process it.
  bool take(btSoftBody& soft, const btCollisionObjectWrapper& other) noexcept;
  /// Returns those since the last call, in the order in which threads came upon them: see restore_order().
  Collected take_collected(RigidPairKind kind);

 private:
  struct List {
    std::atomic<bool> is_collecting = false;
    Collected collected;
  };
  List& list(RigidPairKind kind) { return lists_[static_cast<std::size_t>(kind)]; }
  bool add(RigidPairKind kind, const RigidPair& pair) noexcept;

  std::mutex mutex_;
  std::array<List, 2> lists_;
};

/// Between construction and destruction `dispatcher` hands over the pairs of these kinds whose algorithm it makes now,
/// or made in such a time before. Allocates nothing.
class CollectingRigidPairs {
 public:
  CollectingRigidPairs(btCollisionDispatcher& dispatcher, std::shared_ptr<RigidPairs> pairs, bool meshes, bool convex);
  ~CollectingRigidPairs();
  CollectingRigidPairs(const CollectingRigidPairs&) = delete;
  CollectingRigidPairs& operator=(const CollectingRigidPairs&) = delete;

 private:
  /// Makes algorithms in front of those that would have been made without it.
  class CreateFunc : public btCollisionAlgorithmCreateFunc {
   public:
    CreateFunc(btCollisionDispatcher& dispatcher, int type0, int type1, std::shared_ptr<RigidPairs> pairs);
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override;

   private:
    std::shared_ptr<RigidPairs> pairs_;
    bool is_swapped_;
    RegisteredAlgorithm registered_;
  };
  void stand_before(btCollisionDispatcher& dispatcher, int type);

  std::shared_ptr<RigidPairs> pairs_;
  /// Two for each type of shape. Bullet has fewer types than that.
  std::array<std::optional<CreateFunc>, 2 * std::size_t{MAX_BROADPHASE_COLLISION_TYPES}> creators_;
  std::size_t creator_count_ = 0;
};

/// Has Bullet, or the app where that has registered an algorithm, process a pair with a mesh. Not while pairs are
/// collected.
void process_natively(const RigidPair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info);

/// Frees the algorithms of pairs of soft bodies and others: the next dispatch makes new ones.
void forget_rigid_algorithms(btOverlappingPairCache& pair_cache, btDispatcher& dispatcher);

}  // namespace softcd::bullet
