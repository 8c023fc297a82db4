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

/// Any Bullet broad phase, plus the list of soft bodies in it. Hand it to the world in place of the original one:
///
///     softcd::bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
///     softcd::bullet::Dispatcher dispatcher(&configuration, broadphase);
///
/// All calls go to the original; getOverlappingPairCache() is the original's. With Settings::rigid_meshes the soft
/// bodies' boxes cover their whole way in a step when pairs are calculated, not one end of it.
///
/// Every body's VF_SS flag is hidden from the moment at which the body is added until the first dispatch after it, so
/// that Bullet builds no face tree in between. (Bullet's build takes time quadratic in the faces; no function of ours
/// runs between addSoftBody and it.) In that short time the app sees its flags without VF_SS; assigning them anew, or
/// setting VF_SS, works as ever. Clearing only VF_SS there goes unnoticed.
class SOFTCD_EXPORT Broadphase : public btBroadphaseInterface {
 public:
  /// Takes `original` over.
  explicit Broadphase(std::unique_ptr<btBroadphaseInterface> original);
  /// The caller keeps `original` alive.
  explicit Broadphase(btBroadphaseInterface& original);
  ~Broadphase() override;

  /// In the order in which they were added.
  const std::vector<btSoftBody*>& soft_bodies() const { return soft_bodies_; }

  /// As the original's.
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

  /// The settings of the Dispatcher that detects these bodies' contacts, as long as there is one.
  void attach(const Settings& settings);
  /// Hides no flag any more.
  void detach();
  /// Gives all hidden flags back.
  void restore_vertex_face_flags();

  std::shared_ptr<Broadphase> self_{this, [](Broadphase*) {}};  ///< tells a Dispatcher whether it still lives
  std::unique_ptr<btBroadphaseInterface> owned_;
  btBroadphaseInterface& original_;
  std::vector<btSoftBody*> soft_bodies_;
  const Settings* settings_ = nullptr;  ///< null without a Dispatcher
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
