#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"
#include "softcd/bullet/deformable_world.hpp"

class btDeformableGravityForce;
class btDeformableMassSpringForce;
class btDeformableMultiBodyConstraintSolver;

namespace softcd::demo {

/// The material of a mass-spring body.
struct DeformableMaterial {
  btScalar elastic = 30;             ///< N/m, of every link
  btScalar damping = btScalar(0.2);  ///< N s/m
  btScalar bending = btScalar(0.5);  ///< N/m, of the links over two edges
};

/// A deformable world with all its parts, and its bodies: masses and springs under gravity.
class DeformableSimulation {
 public:
  /// Makes the world; Bullet's own one without settings.
  explicit DeformableSimulation(const std::optional<bullet::Settings>& settings,
                                const DeformableMaterial& material = {});
  ~DeformableSimulation();
  DeformableSimulation(const DeformableSimulation&) = delete;
  DeformableSimulation& operator=(const DeformableSimulation&) = delete;

  btDeformableMultiBodyDynamicsWorld& world() { return *world_; }
  btSoftBodyWorldInfo& world_info() { return world_->getWorldInfo(); }
  /// Null when Bullet detects.
  bullet::WorldDetection* detection() const { return detection_; }

  /// Adds a body of make_cloth or make_ball. Sets the deformable world's flags: contacts of nodes with rigid bodies
  /// (SDF_RDN) and with faces (VF_DD).
  btSoftBody& add(std::unique_ptr<btSoftBody> body, int filter_group = btBroadphaseProxy::DefaultFilter,
                  int filter_mask = btBroadphaseProxy::AllFilter);
  /// Takes the body out of the world; it can be added again.
  std::unique_ptr<btSoftBody> remove(btSoftBody& body);
  /// Sets the gravity, also for soft bodies that are in the world already.
  void set_gravity(const btVector3& gravity);
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass = 0);

  /// Makes one step of the given length, without substeps.
  void step(btScalar seconds);

 private:
  // In the order of their dependence.
  std::unique_ptr<btCollisionConfiguration> configuration_;
  std::unique_ptr<btBroadphaseInterface> broadphase_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btDeformableBodySolver> deformable_solver_;
  std::unique_ptr<btDeformableMultiBodyConstraintSolver> solver_;
  std::unique_ptr<btDeformableGravityForce> gravity_;
  std::unique_ptr<btDeformableMassSpringForce> springs_;
  std::vector<std::unique_ptr<btSoftBody>> soft_bodies_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> rigid_bodies_;
  std::unique_ptr<btDeformableMultiBodyDynamicsWorld> world_;
  bullet::WorldDetection* detection_ = nullptr;
};

}  // namespace softcd::demo
