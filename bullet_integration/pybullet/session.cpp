#include "session.hpp"

#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <CommonInterfaces/CommonGUIHelperInterface.h>
#include <SharedMemory/PhysicsCommandProcessorInterface.h>

#include <new>

#include "softcd/error.hpp"

namespace softcd::bullet::pybullet {
namespace {

struct FoundWorld {
  btDiscreteDynamicsWorld* world;
};

/// Receives the server's world. The server passes its world to a new GUI helper before it replaces its present helper.
/// An exception at that time leaves the server as it was.
class WorldFinder : public DummyGUIHelper {
 public:
  void createPhysicsDebugDrawer(btDiscreteDynamicsWorld* world) override { throw FoundWorld{world}; }
};

btDynamicsWorld& world_of(PhysicsCommandProcessorInterface& server) {
  WorldFinder finder;
  try {
    server.setGuiHelper(&finder);
  } catch (const FoundWorld& found) {
    return *found.world;
  }
  throw Error(
      "PyBullet did not show its world: softcd's plugin was built for another version of PyBullet; reinstall it.");
}

}  // namespace

/// An object in the world, far from everything, that collides with nothing. It has a type of its own, so that PyBullet
/// does not take it for a rigid body and saves nothing of it.
class Session::Sentinel : public btCollisionObject {
 public:
  explicit Sentinel(Session& session) : session_(session) {
    m_internalType = CO_USER_TYPE;
    setCollisionShape(&shape_);
    setCollisionFlags(CF_STATIC_OBJECT | CF_NO_CONTACT_RESPONSE);
    forceActivationState(DISABLE_SIMULATION);
    getWorldTransform().setOrigin({kFar, kFar, kFar});
  }
  ~Sentinel() override { session_.lose_world(); }

 private:
  static constexpr btScalar kFar = 1e15;

  Session& session_;
  btEmptyShape shape_;
};

Session::~Session() {
  try {
    detach();
  } catch (...) {
    // The world is detached nevertheless.
  }
}

void Session::attach(PhysicsCommandProcessorInterface& server, Settings settings) {
  btDynamicsWorld& present = world(server);
  if (attachment() != nullptr) throw InvalidInput("softcd is attached to this world already; detach it first.");
  add_callbacks(settings);
  attachment_.emplace(bullet::attach(present, settings));
  watch(present);
}

void Session::detach() {
  if (sentinel_ == nullptr) return;
  world_->removeCollisionObject(sentinel_);
  delete sentinel_;
}

Attachment* Session::attachment() {
  return attachment_.has_value() ? &*attachment_ : nullptr;
}

void Session::set_settings(Settings settings) {
  add_callbacks(settings);
  attachment_->detection().set_settings(settings);
}

btDynamicsWorld& Session::world(PhysicsCommandProcessorInterface& server) {
  return world_ != nullptr ? *world_ : world_of(server);
}

WorldProbe& Session::probe(PhysicsCommandProcessorInterface& server) {
  if (!probe_.has_value()) {
    btDynamicsWorld& present = world(server);
    probe_.emplace(present, log());
    watch(present);
  }
  return *probe_;
}

/// Learns from now on when the world is deleted.
void Session::watch(btDynamicsWorld& world) {
  if (sentinel_ != nullptr) return;
  world_ = &world;
  sentinel_ = new Sentinel(*this);
  world.addCollisionObject(sentinel_, 0, 0);
}

/// Called when the sentinel is destroyed, while the world still exists.
void Session::lose_world() {
  sentinel_ = nullptr;
  attachment_.reset();  // may finish a step
  probe_.reset();
  world_ = nullptr;
  impulses_ = {};
}

/// An exception would pass through PyBullet's server and end the process. A message without memory is lost.
LogCallback Session::log() {
  return [this](LogLevel level, std::string_view message) {
    try {
      if (messages_.size() < kMostMessages) messages_.emplace_back(level, message);
    } catch (const std::bad_alloc&) {
    }
  };
}

void Session::add_callbacks(Settings& settings) {
  settings.log = log();
  settings.on_contacts = {};
  if (settings.read_out != ReadOut::impulses) return;
  settings.on_contacts = [this](const std::vector<BodyPairContacts>& pairs) {
    impulses_.add(pairs, world_->getDispatchInfo().m_timeStep);
  };
}

}  // namespace softcd::bullet::pybullet
