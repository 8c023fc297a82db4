#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/bullet/attach.hpp"

class btBroadphaseInterface;
class btCollisionConfiguration;
class btCollisionDispatcher;
class btDiscreteDynamicsWorld;
class btMultiBodyConstraintSolver;
class btSoftMultiBodyDynamicsWorld;
class btSoftRigidDynamicsWorld;

namespace softcd::demo {

/// The detector of vertex-face contacts of soft bodies, and the kind of softcd's integration.
enum class PlugIn : std::uint32_t {
  none,              ///< Bullet's btSoftRigidDynamicsWorld alone
  none_multi_body,   ///< Bullet's btSoftMultiBodyDynamicsWorld alone
  one_line_world,    ///< softcd::bullet::SoftRigidDynamicsWorld
  multi_body_world,  ///< softcd::bullet::SoftMultiBodyDynamicsWorld
  dispatcher,        ///< softcd::bullet::Broadphase and Dispatcher under Bullet's btSoftRigidDynamicsWorld
  attached,          ///< softcd::bullet::attach() to Bullet's btSoftRigidDynamicsWorld
};

/// A classic soft world with all its parts, and its bodies.
class Simulation {
 public:
  explicit Simulation(PlugIn plug_in, const bullet::Settings& settings = {});
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  btDiscreteDynamicsWorld& world() { return *world_; }
  btSoftBodyWorldInfo& world_info() { return *world_info_; }
  btCollisionDispatcher& dispatcher() { return *dispatcher_; }

  btSoftBody& add(std::unique_ptr<btSoftBody> body, int filter_group = btBroadphaseProxy::DefaultFilter,
                  int filter_mask = btBroadphaseProxy::AllFilter);
  /// Takes the body out of the world; it can be added again.
  std::unique_ptr<btSoftBody> remove(btSoftBody& body);
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass = 0);
  void set_gravity(const btVector3& gravity);
  /// Adds a box that does not move.
  btRigidBody& add_static_box(const btVector3& half_extents, const btVector3& center);

  /// Destroys the world alone, with the bodies still in it.
  void destroy_world();

  /// Makes one step of the given length, without substeps.
  void step(btScalar seconds);

  /// Returns softcd's detection; null when Bullet detects.
  bullet::WorldDetection* detection() const { return detection_; }

 private:
  void make_world(PlugIn plug_in, const bullet::Settings& settings);
  void use(std::unique_ptr<btSoftMultiBodyDynamicsWorld> world);

  // In the order of their dependence.
  std::unique_ptr<btCollisionConfiguration> configuration_;
  std::unique_ptr<btBroadphaseInterface> broadphase_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btMultiBodyConstraintSolver> solver_;
  std::vector<std::unique_ptr<btSoftBody>> soft_bodies_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> rigid_bodies_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  btSoftRigidDynamicsWorld* soft_rigid_world_ = nullptr;           ///< world_, where it is one
  btSoftMultiBodyDynamicsWorld* soft_multi_body_world_ = nullptr;  ///< world_, where it is one
  btSoftBodyWorldInfo* world_info_ = nullptr;
  std::optional<bullet::Attachment> attachment_;
  bullet::WorldDetection* detection_ = nullptr;
};

}  // namespace softcd::demo
