#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <memory>
#include <optional>

#include "softcd/bullet/attach.hpp"

class PhysicsCommandProcessorInterface;

namespace softcd::bullet::pybullet {

/// softcd in the world of one of PyBullet's servers, which may delete its world at any time and make another
/// (resetSimulation, disconnect): the attachment ends before.
class Session {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// To the server's world of now. Throws as softcd::bullet::attach().
  void attach(PhysicsCommandProcessorInterface& server, const Settings& settings);
  /// Throws as Attachment::detach(). Does nothing where there is nothing attached.
  void detach();
  /// Null where there is none, or its world is gone.
  Attachment* attachment();

 private:
  class Sentinel;
  void lose_world();

  std::optional<Attachment> attachment_;
  btDynamicsWorld* world_ = nullptr;
  Sentinel* sentinel_ = nullptr;  ///< its owner is the world's, who deletes whatever is in it
};

}  // namespace softcd::bullet::pybullet
