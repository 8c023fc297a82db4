#pragma once

#include <memory>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"
#include "softcd/bullet/settings.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

class btSoftBody;

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// A wrapper around any Bullet broad phase that lists its soft bodies. Give it to the world in place of the original:
///
///     softcd::bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
///     softcd::bullet::Dispatcher dispatcher(&configuration, broadphase);
///
/// All calls go to the original, and getOverlappingPairCache() returns the original's. With Settings::rigid_meshes, or
/// contacts with convex shapes, a soft body's box covers its whole path in the step when pairs are calculated.
///
/// From the moment a body is added until the first dispatch, the wrapper hides the body's VF_SS flag. Otherwise Bullet
/// would build a face tree, in time quadratic in the faces. In that time the app sees the flags without VF_SS.
/// Assigning all flags, or setting VF_SS, works as usual; clearing VF_SS alone has no effect.
class SOFTCD_EXPORT Broadphase : public btBroadphaseInterface {
 public:
  /// Takes ownership of `original`.
  explicit Broadphase(std::unique_ptr<btBroadphaseInterface> original);
  /// The caller keeps `original` alive.
  explicit Broadphase(btBroadphaseInterface& original);
  ~Broadphase() override;

  /// Returns the soft bodies in the order in which they were added.
  const std::vector<btSoftBody*>& soft_bodies() const { return soft_bodies_; }

  /// Forward to the original.
  ///@{
  btBroadphaseProxy* createProxy(const btVector3& aabb_min, const btVector3& aabb_max, int shape_type, void* user,
                                 int filter_group, int filter_mask, btDispatcher* dispatcher) override;
  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  void setAabb(btBroadphaseProxy* proxy, const btVector3& aabb_min, const btVector3& aabb_max,
               btDispatcher* dispatcher) override;
  void getAabb(btBroadphaseProxy* proxy, btVector3& aabb_min, btVector3& aabb_max) const override;
  void rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
               const btVector3& aabb_min = btVector3(0, 0, 0), const btVector3& aabb_max = btVector3(0, 0, 0)) override;
  void aabbTest(const btVector3& aabb_min, const btVector3& aabb_max, btBroadphaseAabbCallback& callback) override;
  void calculateOverlappingPairs(btDispatcher* dispatcher) override;
  btOverlappingPairCache* getOverlappingPairCache() override;
  const btOverlappingPairCache* getOverlappingPairCache() const override;
  void getBroadphaseAabb(btVector3& aabb_min, btVector3& aabb_max) const override;
  void resetPool(btDispatcher* dispatcher) override;
  void printStats() override;
  ///@}

 private:
  friend class Dispatcher;

  /// Follows the settings of the Dispatcher that detects these bodies' contacts.
  void attach(const Settings& settings);
  /// Stops hiding flags.
  void detach();
  /// Restores all hidden flags.
  void restore_vertex_face_flags();

  std::shared_ptr<Broadphase> self_{this, [](Broadphase*) {}};  ///< lets a Dispatcher notice its end
  std::unique_ptr<btBroadphaseInterface> owned_;
  btBroadphaseInterface& original_;
  std::vector<btSoftBody*> soft_bodies_;
  const Settings* settings_ = nullptr;  ///< null without a Dispatcher
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
