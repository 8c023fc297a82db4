#pragma once

#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// btDeformableMultiBodyDynamicsWorld with vertex-face contacts between soft bodies (VF_DD) and within them found by
/// softcd. The app changes the line that creates its world.
///
/// The contacts are those that Bullet's rule gives over all pairs of nodes and faces whose boxes in Bullet's trees
/// overlap, each once, in Bullet's own m_faceNodeContacts: Bullet enters those within a body several times, and its
/// cones of normals leave some out. With Settings::detection
/// ccd, bodies that move through each other in a step are stopped; Bullet's own continuous pass has no effect on the
/// motion, and is not run.
///
/// Bullet's response takes contacts in an order that it shuffles with a generator that all worlds of a process share:
/// runs repeat from process to process, not within one.
///
/// Face trees are built for bodies with SDF_RDF or SDF_MDF that are close to a rigid one, and by btSoftBody's own ray
/// tests; only those are refitted. Node trees are refitted for bodies whose boxes overlap a rigid one's. The trees have
/// the shape of Bullet's, and so contacts with rigid bodies come in Bullet's order, which its solver is sensitive to.
///
/// A body that goes on in one of Bullet's own worlds needs a face tree: see give_face_tree().
class SOFTCD_EXPORT DeformableWorld : public btDeformableMultiBodyDynamicsWorld {
 public:
  /// What Bullet's world takes, and the settings. Throws as CollisionPipeline's constructor.
  DeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                  btDeformableMultiBodyConstraintSolver* solver, btCollisionConfiguration* configuration,
                  btDeformableBodySolver* deformable_solver = nullptr, const Settings& settings = {});
  ~DeformableWorld() override;

  /// Settings, and what was found.
  WorldDetection& detection() { return detection_; }
  /// The same.
  const WorldDetection& detection() const { return detection_; }

  /// Between steps: Bullet's own.
  void performDiscreteCollisionDetection() override;
  /// As that of SoftWorld. Bullet's looks at faces alone, not at tetrahedra.
  void rayTest(const btVector3& from, const btVector3& to, RayResultCallback& callback) const override;

 protected:
  /// Bullet's step, with softcd's detection in it.
  void internalSingleStepSimulation(btScalar time_step) override;

 private:
  void predict(btScalar time_step);
  void detect_rigid_contacts();

  btDeformableBodySolver* deformable_solver_;
  WorldDetection detection_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
