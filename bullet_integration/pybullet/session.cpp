#include "session.hpp"

#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <CommonInterfaces/CommonGUIHelperInterface.h>
#include <SharedMemory/PhysicsCommandProcessorInterface.h>

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
  throw Error("PyBullet did not show its world; softcd's plugin was built for another version.");
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

void Session::attach(PhysicsCommandProcessorInterface& server, const Settings& settings) {
  btDynamicsWorld& world = world_of(server);
  if (attachment() != nullptr) throw InvalidInput("softcd is attached to this world already; detach it first.");
  attachment_.emplace(bullet::attach(world, settings));
  world_ = &world;
  sentinel_ = new Sentinel(*this);
  world.addCollisionObject(sentinel_, 0, 0);
}

void Session::detach() {
  if (sentinel_ == nullptr) return;
  world_->removeCollisionObject(sentinel_);
  delete sentinel_;
}

Attachment* Session::attachment() {
  return attachment_.has_value() ? &*attachment_ : nullptr;
}

/// The sentinel is being removed, while the world still exists.
void Session::lose_world() {
  sentinel_ = nullptr;
  world_ = nullptr;
  attachment_.reset();
}

}  // namespace softcd::bullet::pybullet
