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

/// One of Bullet's classic soft worlds, with softcd's contacts between and within soft bodies (VF_SS). The app changes
/// the line that creates its world. It keeps its dispatcher and broad phase. If that dispatcher is a
/// softcd::bullet::Dispatcher for the same broad phase, the dispatcher detects, with its own settings.
///
/// With Detection::ccd a last pass stops nodes that the solver would move through a face.
///
/// Bullet builds and updates no face trees here. It updates a body's node tree only in steps in which the body's box
/// overlaps a rigid body's; debug drawings show the trees of the last such step. Before a body moves to one of Bullet's
/// own worlds, call give_face_tree().
template <class BulletWorld>
class SOFTCD_EXPORT SoftWorld : public BulletWorld {
 public:
  /// The type of solver that the constructor of Bullet's world takes.
  using ConstraintSolver = std::conditional_t<std::is_base_of_v<btMultiBodyDynamicsWorld, BulletWorld>,
                                              btMultiBodyConstraintSolver, btConstraintSolver>;

  /// Takes the parameters of Bullet's world, and the settings. Throws InvalidInput for settings out of range, and
  /// BackendError for a backend that is not there.
  SoftWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, ConstraintSolver* solver,
            btCollisionConfiguration* configuration, btSoftBodySolver* soft_body_solver = nullptr,
            const Settings& settings = {});
  ~SoftWorld() override;

  /// Returns the settings and results: the Dispatcher's, if a softcd::bullet::Dispatcher detects.
  WorldDetection& detection() { return *detection_; }
  /// Returns the same.
  const WorldDetection& detection() const { return *detection_; }

  /// Runs Bullet's detection with softcd's in it.
  void performDiscreteCollisionDetection() override;
  /// Tests a ray against all objects, soft bodies at the current positions of their nodes. No ray passes between two
  /// faces with a common edge. Bullet's face trees are not needed.
  ///
  /// The first ray near a body after a step reads the whole body; later rays do not. An app that moves nodes itself
  /// between two rays calls WorldDetection::forget_ray_positions(). With OnError::throw_error, throws Error if memory
  /// runs out.
  void rayTest(const btVector3& from, const btVector3& to,
               btCollisionWorld::RayResultCallback& callback) const override;

 protected:
  /// Run parts of Bullet's step, with softcd's parts before, between and after them.
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

/// Replaces btSoftRigidDynamicsWorld.
using SoftRigidDynamicsWorld = SoftWorld<btSoftRigidDynamicsWorld>;
/// Replaces btSoftMultiBodyDynamicsWorld.
using SoftMultiBodyDynamicsWorld = SoftWorld<btSoftMultiBodyDynamicsWorld>;

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
