#pragma once

#include <memory>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "softcd/bullet/broadphase.hpp"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// A btCollisionDispatcher with softcd's contacts between and within soft bodies (VF_SS), for all soft bodies of a
/// classic world in one batch. The contacts are Bullet's own btSoftBody::SContact. Bullet still handles rigid,
/// soft-rigid and cluster pairs, at the same time as a detection on a GPU.
///
/// `configuration` and `broadphase` outlive the dispatcher's use by a world. The dispatcher serves the world that uses
/// `broadphase`; a second world that shares it gets Bullet's own detection.
///
/// Prefer the worlds of soft_worlds.hpp, or attach() for a world of Bullet's own class: Bullet calls a dispatcher
/// neither around its prediction nor after its solver. Three flaws of Bullet therefore remain here. It updates every
/// body's node tree. It builds a face tree after each change of topology or of a mass, in time quadratic in the faces,
/// and never finishes if the change splits a body. And nothing follows the solver: with Detection::ccd it may move
/// nodes through faces, and Settings::untangle has no effect. The log says each once, the second only with
/// Untangle::all.
///
/// Bullet would never finish the face tree of a body in several parts, either: common edges do not connect all its
/// faces, or links not all its nodes. Where a body is like that when pairs are dispatched, softcd gives it a face tree
/// and hides its VF_SS flag until the next dispatch, as Broadphase does before the first one.
class SOFTCD_EXPORT Dispatcher : public btCollisionDispatcher {
 public:
  /// Throws InvalidInput for settings out of range, and BackendError for a backend that is not there.
  Dispatcher(btCollisionConfiguration* configuration, Broadphase& broadphase, const Settings& settings = {});
  ~Dispatcher() override;

  /// Dispatches all pairs and detects soft contacts. Bullet calls it.
  void dispatchAllCollisionPairs(btOverlappingPairCache* pair_cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

  /// Returns the settings and results.
  WorldDetection& detection() { return detection_; }
  /// Returns the same.
  const WorldDetection& detection() const { return detection_; }
  /// Returns whether it detects the contacts of the world that uses this broad phase.
  bool serves(const btBroadphaseInterface& broadphase) const;

 private:
  void warn_of_missing_end();

  Broadphase& broadphase_;
  std::weak_ptr<Broadphase> living_broadphase_;  ///< apps delete the two in either order
  WorldDetection detection_;
  bool has_warned_of_crossings_ = false, has_warned_of_untangling_ = false;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
