#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "impulse_sums.hpp"
#include "softcd/bullet/attach.hpp"
#include "softcd/bullet/world_probe.hpp"

class PhysicsCommandProcessorInterface;

namespace softcd::bullet::pybullet {

/// softcd in the world of one of PyBullet's servers, which may delete its world at any time and make another
/// (resetSimulation, disconnect): the attachment and the probe end before.
class Session {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Attaches to the server's present world; messages go to take_messages(). Throws as softcd::bullet::attach().
  void attach(PhysicsCommandProcessorInterface& server, Settings settings);
  /// Ends the attachment and the probe. Does nothing where there are none.
  void detach();
  /// Returns the attachment, or null where there is none, or its world is gone.
  Attachment* attachment();
  /// Changes the attachment's settings. Throws as WorldDetection::set_settings().
  void set_settings(Settings settings);

  /// Returns the impulses of pairs since the last call, as ImpulseSums::take().
  std::string take_impulses() { return impulses_.take(); }

  /// Returns the server's present world.
  btDynamicsWorld& world(PhysicsCommandProcessorInterface& server);
  /// Returns the probe of the server's present world, whether softcd is attached or not.
  WorldProbe& probe(PhysicsCommandProcessorInterface& server);

  /// Appends to the input of a coming command. A client cannot send much at once.
  void add_input(std::string_view bytes) { input_.append(bytes); }
  /// Returns the input since the last call.
  std::string take_input() { return std::exchange(input_, {}); }
  /// Returns the messages since the last call, at most kMostMessages of them: the oldest.
  std::vector<std::pair<LogLevel, std::string>> take_messages() { return std::exchange(messages_, {}); }

  static constexpr std::size_t kMostMessages = 1000;

 private:
  class Sentinel;
  void watch(btDynamicsWorld& world);
  void lose_world();
  LogCallback log();
  void add_callbacks(Settings& settings);

  std::optional<Attachment> attachment_;
  std::optional<WorldProbe> probe_;
  btDynamicsWorld* world_ = nullptr;  ///< where the sentinel is
  Sentinel* sentinel_ = nullptr;      ///< owned by the world, which deletes all its objects
  ImpulseSums impulses_;
  std::string input_;
  std::vector<std::pair<LogLevel, std::string>> messages_;
};

}  // namespace softcd::bullet::pybullet
