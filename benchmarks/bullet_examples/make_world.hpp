#pragma once

#include <optional>
#include <type_traits>

#include "BulletSoftBody/btDeformableBodySolver.h"
#include "softcd/bullet/deformable_world.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::benchmarks {

/// The settings of this process's world; without settings it is Bullet's own.
inline std::optional<bullet::Settings> example_settings;
/// The soft bodies of this process's world, once it is made.
inline btSoftBodyArray* example_bodies = nullptr;

}  // namespace softcd::benchmarks

/// Creates the world of one of Bullet's examples. CMake writes this into copies of Bullet's sources where they have
/// `new`.
template <class BulletWorld, class... Arguments>
BulletWorld* make_world(Arguments... arguments) {
  constexpr bool kIsClassic = std::is_same_v<BulletWorld, btSoftRigidDynamicsWorld>;
  using SoftcdWorld =
      std::conditional_t<kIsClassic, softcd::bullet::SoftRigidDynamicsWorld, softcd::bullet::DeformableWorld>;
  const auto& settings = softcd::benchmarks::example_settings;
  BulletWorld* world = settings ? new SoftcdWorld(arguments..., *settings) : new BulletWorld(arguments...);
  softcd::benchmarks::example_bodies = &world->getSoftBodyArray();
  return world;
}
