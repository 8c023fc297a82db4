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

/// A world of either kind, Bullet's own or softcd's, and its bodies. Nothing in it falls asleep.
class SoftWorld {
 public:
  /// Makes the world. In the deformable world, any `plug_in` that is not Bullet alone means softcd's world.
  SoftWorld(World kind, PlugIn plug_in, const bullet::Settings& settings);

  World kind() const { return classic_ != nullptr ? World::classic : World::deformable; }
  btSoftBodyWorldInfo& world_info();
  /// Adds a body. In the deformable world it gets masses for which its springs are stable.
  btSoftBody& add(std::unique_ptr<btSoftBody> body);
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass = 0);
  void set_gravity(const btVector3& gravity);
  /// Turns soft contacts off for all bodies.
  void stop_soft_contacts();
  void step() { step(time_step()); }
  void step(btScalar seconds);
  /// Returns a step, in seconds, for which all scenes are stable.
  btScalar time_step() const;

  const std::vector<btSoftBody*>& bodies() const { return bodies_; }
  /// Return softcd's detection; null when Bullet detects.
  const bullet::WorldDetection* detection() const;
  bullet::WorldDetection* detection();
  /// Return the number of contacts that Bullet's solver received in the last step.
  std::size_t count_soft_contacts() const;
  std::size_t count_rigid_contacts() const;

 private:
  // Only one of the two exists.
  std::unique_ptr<Simulation> classic_;
  std::unique_ptr<DeformableSimulation> deformable_;
  std::vector<btSoftBody*> bodies_;
};

}  // namespace softcd::demo
