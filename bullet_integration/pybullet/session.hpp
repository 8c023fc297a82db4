#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <memory>
#include <optional>

#include "softcd/bullet/attach.hpp"

class PhysicsCommandProcessorInterface;

namespace softcd::bullet::pybullet {

/// softcd in the world of one of PyBullet's servers. The server may delete its world at any time and make another
/// (resetSimulation, disconnect). The attachment ends before that.
class Session {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Attaches to the server's present world. Throws as softcd::bullet::attach() does.
  void attach(PhysicsCommandProcessorInterface& server, const Settings& settings);
  /// Detaches. Throws as Attachment::detach() does. Does nothing if nothing is attached.
  void detach();
  /// Returns null if there is no attachment, or its world is gone.
  Attachment* attachment();

 private:
  class Sentinel;
  void lose_world();

  std::optional<Attachment> attachment_;
  btDynamicsWorld* world_ = nullptr;
  Sentinel* sentinel_ = nullptr;  ///< owned by the world, which deletes its objects
};

}  // namespace softcd::bullet::pybullet
