#pragma once

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletSoftBody/btSoftBody.h"

class btCollisionDispatcher;

namespace softcd::bullet {

/// Whether softcd, not Bullet, is responsible for the vertex-face contacts of a pair: Bullet's own rule.
inline bool is_vertex_face_pair(const btSoftBody& a, const btSoftBody& b) {
  using Flags = btSoftBody::fCollision;
  return (a.m_cfg.collisions & b.m_cfg.collisions & Flags::SVSmask) == Flags::VF_SS;
}

/// The same of vertex-face contacts in the deformable world.
inline bool is_deformable_pair(const btSoftBody& a, const btSoftBody& b) {
  using Flags = btSoftBody::fCollision;
  return (a.m_cfg.collisions & b.m_cfg.collisions & Flags::SVSmask) == Flags::VF_DD;
}

/// Makes the near callback of `dispatcher` tell a PairGate which pairs of soft bodies it lets through. Outside of
/// PairGate::admits, pairs are processed by Bullet as before.
void install_pair_recorder(btCollisionDispatcher& dispatcher);

/// Asks everything but the bodies' flags that decides in Bullet whether two soft bodies may collide: filter groups and
/// masks or the overlap filter callback, the dispatcher's near callback, and through it activation and ignored pairs.
class PairGate {
 public:
  PairGate(btDispatcher& dispatcher, btOverlappingPairCache& pair_cache, const btDispatcherInfo& info)
      : dispatcher_(dispatcher), pair_cache_(pair_cache), info_(info) {}

  bool admits(btSoftBody& a, btSoftBody& b) const;
  /// The classic worlds' rule.
  bool admits_vertex_face_pair(btSoftBody& a, btSoftBody& b) const { return is_vertex_face_pair(a, b) && admits(a, b); }

 private:
  btDispatcher& dispatcher_;
  btOverlappingPairCache& pair_cache_;
  const btDispatcherInfo& info_;
};

}  // namespace softcd::bullet
