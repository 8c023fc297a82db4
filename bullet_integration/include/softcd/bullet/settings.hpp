#pragma once

#include <cstdint>

#include "softcd/softcd.hpp"

namespace softcd::bullet {

/// Which soft bodies collide with themselves, vertex against triangle. Bullet's classic soft worlds have no such
/// test. A body's margin should then be at most a quarter of its edges' rest length: features that are closer than
/// twice the margin at rest would push each other all the time.
enum class SelfCollision : std::uint32_t {
  flagged,  ///< bodies with VF_SS on which setSelfCollision(true) was called; Bullet's default is false
  all,      ///< every body with VF_SS
  none,
};

/// How softcd replaces Bullet's vertex-face soft-soft detection (fCollision::VF_SS). All other kinds of collision,
/// clusters among them, stay Bullet's.
struct Settings {
  Backend backend = Backend::automatic;
  /// dcd: Bullet's own rule. A node touches a face when their distance at the end of the step is less than both
  /// bodies' margins plus twice the distance that the node moves in the step.
  /// ccd: the motion of the whole step is tested, so that nothing passes through however fast it is, and the margin
  /// does not grow with speed.
  Detection detection = Detection::dcd;
  Accuracy accuracy = Accuracy::precise;
  BroadPhase broad_phase = BroadPhase::exact;
  float lambda = 0.0F;  ///< cell size, see PipelineOptions::lambda; 0 chooses
  SelfCollision self_collision = SelfCollision::flagged;
  LogCallback log;
};

}  // namespace softcd::bullet
