#pragma once

#include <memory>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "softcd/bullet/broadphase.hpp"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Bullet's dispatcher, with vertex-face contacts between soft bodies (VF_SS) and within them found by softcd, for
/// all bodies of a classic soft world in one batch. Rigid, soft-rigid and cluster pairs are Bullet's as before and
/// overlap the detection when it runs on a GPU. The contacts are Bullet's own btSoftBody::SContact.
///
/// Both `configuration` and `broadphase` outlive the dispatcher's use by a world. Serves the world that uses
/// `broadphase`; a second world that shares the dispatcher gets Bullet's own detection.
///
/// Three flaws of Bullet's remain here and are gone in the one-line worlds of soft_worlds.hpp, which have a hook around
/// Bullet's prediction: the update of every body's node tree; the build of its face tree after every change of a body's
/// topology, which takes time quadratic in the faces, and never ends for faces that links do not connect; and, with
/// Settings::detection ccd, what Bullet's solver makes of the contacts is not looked at again, so that something may
/// still pass through: nothing of a btSoftRigidDynamicsWorld calls a dispatcher after its solver of soft bodies. The
/// log says so once. For a world of Bullet's own class with that look there is attach() (attach.hpp).
class SOFTCD_EXPORT Dispatcher : public btCollisionDispatcher {
 public:
  /// Throws as CollisionPipeline's constructor.
  Dispatcher(btCollisionConfiguration* configuration, Broadphase& broadphase, const Settings& settings = {});
  ~Dispatcher() override;

  /// Called by Bullet: dispatches all pairs, and detects beside that.
  void dispatchAllCollisionPairs(btOverlappingPairCache* pair_cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

  /// Settings, and what was found.
  WorldDetection& detection() { return detection_; }
  /// The same.
  const WorldDetection& detection() const { return detection_; }
  /// Whether the world that uses this broad phase is the one whose contacts it finds.
  bool serves(const btBroadphaseInterface& broadphase) const;

 private:
  void warn_of_crossings();

  Broadphase& broadphase_;
  std::weak_ptr<Broadphase> living_broadphase_;  ///< apps delete the two in either order
  WorldDetection detection_;
  bool has_warned_ = false;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
