#pragma once

#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// btDeformableMultiBodyDynamicsWorld, with softcd's contacts between and within soft bodies (VF_DD). The app changes
/// the line that creates its world.
///
/// The contacts are those of Bullet's rule, for all nodes and faces whose boxes in Bullet's trees overlap. Each stands
/// once in Bullet's own m_faceNodeContacts. Bullet alone repeats contacts within a body, and misses some of them. With
/// Detection::ccd a last pass stops bodies that would cross; it replaces Bullet's own continuous pass.
///
/// Bullet's solver shuffles contacts with a generator that all worlds of a process share. Runs repeat from process to
/// process, not within one process.
///
/// Bullet builds face trees only for bodies with SDF_RDF or SDF_MDF near a rigid body, and for btSoftBody::rayTest. It
/// updates node trees only of bodies whose boxes overlap a rigid body's. These trees have Bullet's own shape: its
/// solver depends on the order of contacts that they give. Before a body moves to one of Bullet's own worlds, call
/// give_face_tree().
class SOFTCD_EXPORT DeformableWorld : public btDeformableMultiBodyDynamicsWorld {
 public:
  /// Takes the parameters of Bullet's world, and the settings. Throws InvalidInput for settings out of range, and
  /// BackendError for a backend that is not there.
  DeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                  btDeformableMultiBodyConstraintSolver* solver, btCollisionConfiguration* configuration,
                  btDeformableBodySolver* deformable_solver = nullptr, const Settings& settings = {});
  ~DeformableWorld() override;

  /// Returns the settings and results.
  WorldDetection& detection() { return detection_; }
  /// Returns the same.
  const WorldDetection& detection() const { return detection_; }

  /// Runs Bullet's own detection, for calls between steps.
  void performDiscreteCollisionDetection() override;
  /// Tests a ray as SoftWorld::rayTest does, against faces only, like Bullet's own.
  void rayTest(const btVector3& from, const btVector3& to, RayResultCallback& callback) const override;

 protected:
  /// Runs Bullet's step with softcd's detection in it.
  void internalSingleStepSimulation(btScalar time_step) override;

 private:
  btDeformableBodySolver* deformable_solver_;
  WorldDetection detection_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
