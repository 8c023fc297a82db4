#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "scenes/deformable_simulation.hpp"
#include "scenes/simulation.hpp"

namespace softcd::demo {

enum class World : std::uint32_t {
  classic,     ///< positions are projected: btSoftRigidDynamicsWorld
  deformable,  ///< forces: btDeformableMultiBodyDynamicsWorld
};

/// A world of either kind, Bullet's own or softcd's, and the bodies in it. Nothing in it falls asleep.
class SoftWorld {
 public:
  /// Of the deformable world, softcd's for any `plug_in` that is not Bullet alone.
  SoftWorld(World kind, PlugIn plug_in, const bullet::Settings& settings);

  World kind() const { return classic_ != nullptr ? World::classic : World::deformable; }
  btSoftBodyWorldInfo& world_info();
  /// In the deformable world the body gets masses with which its springs are stable.
  btSoftBody& add(std::unique_ptr<btSoftBody> body);
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass = 0);
  void set_gravity(const btVector3& gravity);
  /// From now on no body asks for contacts with soft bodies.
  void stop_soft_contacts();
  void step() { step(time_step()); }
  void step(btScalar seconds);
  /// With which all scenes are stable, seconds.
  btScalar time_step() const;

  const std::vector<btSoftBody*>& bodies() const { return bodies_; }
  /// Null when Bullet detects.
  const bullet::WorldDetection* detection() const;
  bullet::WorldDetection* detection();
  /// What Bullet's solver was given in the last step.
  std::size_t count_soft_contacts() const;
  std::size_t count_rigid_contacts() const;

 private:
  // One of the two.
  std::unique_ptr<Simulation> classic_;
  std::unique_ptr<DeformableSimulation> deformable_;
  std::vector<btSoftBody*> bodies_;
};

}  // namespace softcd::demo
