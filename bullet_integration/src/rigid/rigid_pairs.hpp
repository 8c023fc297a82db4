#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"
#include "BulletSoftBody/btSoftBody.h"
#include "native/pair_gate.hpp"

class btCollisionDispatcher;
struct btDispatcherInfo;

namespace softcd::bullet {

/// A soft body and a rigid shape that Bullet wants to collide: their boxes overlap and every filter agrees.
struct RigidPair {
  btSoftBody* soft;
  const btCollisionObject* object;
  const btCollisionShape* shape;  ///< a triangle mesh; or the object's whole shape, convex or a compound
  btTransform shape_in_object;    ///< differs from the identity for a compound's child
  int child;                      ///< number among the object's children; -1 if the shape is the object's own
};

/// The kind of contacts that softcd detects in a pair.
enum class RigidPairKind : std::uint8_t {
  mesh,    ///< with a triangle mesh; Bullet does not process collected pairs
  convex,  ///< with a convex object or a compound; Bullet processes it as usual
};

/// Returns whether the shape is a btBvhTriangleMeshShape, one of its scaled and multi-material forms, GImpact or a
/// btHeightfieldTerrainShape.
bool is_triangle_mesh(const btCollisionShape& shape);
/// Returns whether softcd detects contacts of the soft body (with SDF_RS or SDF_RD) with the object's meshes. Not for
/// meshes of multibody links, nor for objects to which the body is anchored with collisions disabled.
bool takes_meshes_of(const btSoftBody& soft, const btCollisionObject& object);

/// Collects pairs while Bullet dispatches. Thread-safe, because some dispatchers use several threads. Owned by
/// WorldQueries, together with the algorithms that CollectingRigidPairs makes.
class RigidPairs {
 public:
  struct Collected {
    std::vector<RigidPair> pairs;
    bool is_complete = true;  ///< false if memory ran out
  };

  void set_collecting(RigidPairKind kind, bool is_collecting) { list(kind).is_collecting = is_collecting; }
  /// Adds the pair if its kind is collected and softcd detects its contacts. Returns whether Bullet must not process
  /// it.
  bool take(btSoftBody& soft, const btCollisionObjectWrapper& other) noexcept;
  /// Returns the pairs since the last call, in the order in which a single thread visits the pairs of the gate's world.
  /// Several threads visit them in another order in every run. Several pairs of the same two objects (of a compound's
  /// children) keep their order: one thread found all of them.
  Collected take_collected(RigidPairKind kind, const PairGate& gate);

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

/// Makes `dispatcher` pass pairs of these kinds to `pairs` while it lives. This applies to pairs whose algorithm is
/// made now, or was made while an earlier object of this class lived. Allocates nothing.
class CollectingRigidPairs {
 public:
  CollectingRigidPairs(btCollisionDispatcher& dispatcher, std::shared_ptr<RigidPairs> pairs, bool meshes, bool convex);
  ~CollectingRigidPairs();
  CollectingRigidPairs(const CollectingRigidPairs&) = delete;
  CollectingRigidPairs& operator=(const CollectingRigidPairs&) = delete;

 private:
  /// Makes algorithms that wrap those of the entries that it replaces: those for a soft body, on one side, and other
  /// types of shapes.
  class CreateFunc : public btCollisionAlgorithmCreateFunc {
   public:
    /// `pairs` must outlive it.
    CreateFunc(const std::shared_ptr<RigidPairs>& pairs, bool is_swapped) : pairs_(pairs), is_swapped_(is_swapped) {}
    void replace(btCollisionDispatcher& dispatcher, int type);
    void give_back(btCollisionDispatcher& dispatcher, int type);
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override;

   private:
    btCollisionAlgorithmCreateFunc*& entry(btCollisionDispatcher& dispatcher, int type) const;

    const std::shared_ptr<RigidPairs>& pairs_;
    bool is_swapped_;  ///< whether the soft body is the second
    std::array<btCollisionAlgorithmCreateFunc*, MAX_BROADPHASE_COLLISION_TYPES> originals_ = {};
  };
  template <class Visit>
  void for_each_type(Visit visit) const;

  btCollisionDispatcher& dispatcher_;
  std::shared_ptr<RigidPairs> pairs_;
  bool meshes_, convex_;
  CreateFunc soft_first_, soft_second_;
};

/// Processes a pair with a mesh by the registered algorithm, Bullet's or the app's. Must not be called while pairs are
/// collected.
void process_natively(const RigidPair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info);

/// Frees the algorithms of pairs of a soft body and another object. The next dispatch makes new ones.
void forget_rigid_algorithms(btOverlappingPairCache& pair_cache, btDispatcher& dispatcher);

}  // namespace softcd::bullet
