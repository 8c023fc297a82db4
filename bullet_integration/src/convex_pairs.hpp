#pragma once

#include <array>
#include <memory>
#include <optional>

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"
#include "BulletSoftBody/btSoftBody.h"
#include "dispatched_pairs.hpp"
#include "registered_algorithm.hpp"

namespace softcd::bullet {

/// A soft body and an object, of a convex shape or of a compound of any shapes, that Bullet collides.
struct ConvexPair {
  btSoftBody* soft;
  const btCollisionObject* object;
};

using ConvexPairs = DispatchedPairs<ConvexPair>;

/// Makes algorithms that tell of pairs to ConvexPairs while these collect. Pairs are always processed by the algorithm
/// that would have stood there without us.
class ConvexPairCreateFunc : public btCollisionAlgorithmCreateFunc {
 public:
  ConvexPairCreateFunc(btCollisionDispatcher& dispatcher, int type0, int type1, std::shared_ptr<ConvexPairs> pairs);

  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* body0,
                                                 const btCollisionObjectWrapper* body1) override;

 private:
  std::shared_ptr<ConvexPairs> pairs_;
  bool is_swapped_;
  RegisteredAlgorithm registered_;
};

/// Between construction and destruction, what `dispatcher` processes of pairs of soft bodies (with SDF_RS or SDF_RD)
/// and rigid bodies, links of multibodies or plain collision objects that are convex or compounds goes to `pairs`, too,
/// in pairs whose algorithm is made now or was made in such a time before. Not what does not respond to contacts.
class CollectingConvexPairs {
 public:
  CollectingConvexPairs(btCollisionDispatcher& dispatcher, const std::shared_ptr<ConvexPairs>& pairs);
  ~CollectingConvexPairs();
  CollectingConvexPairs(const CollectingConvexPairs&) = delete;
  CollectingConvexPairs& operator=(const CollectingConvexPairs&) = delete;

 private:
  static constexpr int kConvexTypeCount = CONCAVE_SHAPES_START_HERE - BOX_SHAPE_PROXYTYPE;

  ConvexPairs& pairs_;
  std::array<std::optional<ConvexPairCreateFunc>, 2 * (kConvexTypeCount + 1)> creators_;
};

}  // namespace softcd::bullet
