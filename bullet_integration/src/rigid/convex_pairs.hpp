#pragma once

#include <memory>

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletSoftBody/btSoftBody.h"
#include "rigid/collecting_pairs.hpp"

namespace softcd::bullet {

/// A soft body and an object, of a convex shape or of a compound of any shapes, that Bullet collides.
struct ConvexPair {
  btSoftBody* soft;
  const btCollisionObject* object;
};

using ConvexPairs = DispatchedPairs<ConvexPair>;

/// Of shapes: the convex ones, and compounds.
constexpr std::size_t kConvexTypeCount = CONCAVE_SHAPES_START_HERE - BOX_SHAPE_PROXYTYPE + 1;

/// Collects pairs of soft bodies (with SDF_RS or SDF_RD) and rigid bodies, links of multibodies or plain collision
/// objects that are convex or compounds. Not what does not respond to contacts. Bullet processes them as ever.
class CollectingConvexPairs : public CollectingPairs<ConvexPair, kConvexTypeCount> {
 public:
  CollectingConvexPairs(btCollisionDispatcher& dispatcher, const std::shared_ptr<ConvexPairs>& pairs);
};

}  // namespace softcd::bullet
