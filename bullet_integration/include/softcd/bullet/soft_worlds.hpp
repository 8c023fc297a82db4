#pragma once

#include <memory>
#include <type_traits>

#include "BulletSoftBody/btSoftMultiBodyDynamicsWorld.h"
#include "BulletSoftBody/btSoftRigidDynamicsWorld.h"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

class Dispatcher;

/// One of Bullet's classic soft worlds with vertex-face contacts between soft bodies (VF_SS) and within them found by
/// softcd. The app changes the line that creates its world; dispatcher and broad phase are whatever it had, except that
/// a softcd::bullet::Dispatcher that serves the same broad phase keeps its own settings.
///
/// With Settings::detection ccd the way of all nodes through a step is looked at once more at its end, and changed
/// where a node would pass through a face.
///
/// Bullet's face trees are neither built nor refitted, and a body's node tree is refitted only in steps in which
/// the body's box overlaps a rigid one's; debug drawings of these trees show the last state that was needed. A body
/// that goes on in one of Bullet's own worlds needs a face tree: see give_face_tree().
template <class BulletWorld>
class SOFTCD_EXPORT SoftWorld : public BulletWorld {
 public:
  /// What the constructor of Bullet's world takes.
  using ConstraintSolver = std::conditional_t<std::is_base_of_v<btMultiBodyDynamicsWorld, BulletWorld>,
                                              btMultiBodyConstraintSolver, btConstraintSolver>;

  /// What Bullet's world takes, and the settings. Throws as CollisionPipeline's constructor.
  SoftWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, ConstraintSolver* solver,
            btCollisionConfiguration* configuration, btSoftBodySolver* soft_body_solver = nullptr,
            const Settings& settings = {});
  ~SoftWorld() override;

  /// The Dispatcher's, where a softcd::bullet::Dispatcher detects.
  WorldDetection& detection() { return *detection_; }
  /// The same.
  const WorldDetection& detection() const { return *detection_; }

  /// Bullet's, with softcd's detection in it.
  void performDiscreteCollisionDetection() override;
  /// Tests soft bodies where their nodes are now. Faces' normals are those of now; Bullet's face trees, which
  /// the first ray builds in time quadratic in the faces, are not needed. No ray slips through between faces.
  ///
  /// The first ray after a step that comes near a body reads it in whole; later rays do not. An app that moves nodes
  /// itself between two rays without a step in between calls WorldDetection::forget_ray_positions(). With
  /// OnError::throw_error throws Error where memory does not suffice.
  void rayTest(const btVector3& from, const btVector3& to,
               btCollisionWorld::RayResultCallback& callback) const override;

 protected:
  /// Parts of Bullet's step, with what softcd does before, between and after them.
  ///@{
  void predictUnconstraintMotion(btScalar time_step) override;
  void internalSingleStepSimulation(btScalar time_step) override;
  void updateActivationState(btScalar time_step) override;
  ///@}

 private:
  std::unique_ptr<WorldDetection> own_detection_;  ///< null where a Dispatcher detects
  WorldDetection* detection_;
};

extern template class SOFTCD_EXPORT SoftWorld<btSoftRigidDynamicsWorld>;
extern template class SOFTCD_EXPORT SoftWorld<btSoftMultiBodyDynamicsWorld>;

/// In place of btSoftRigidDynamicsWorld.
using SoftRigidDynamicsWorld = SoftWorld<btSoftRigidDynamicsWorld>;
/// In place of btSoftMultiBodyDynamicsWorld.
using SoftMultiBodyDynamicsWorld = SoftWorld<btSoftMultiBodyDynamicsWorld>;

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
