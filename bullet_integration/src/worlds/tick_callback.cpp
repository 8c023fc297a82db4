#include "worlds/tick_callback.hpp"

namespace softcd::bullet {
namespace {

// Bullet has a function to set tick callbacks, but none to read them. The app's own must still be called.
struct Callbacks : btDynamicsWorld {
  static btInternalTickCallback of(btDynamicsWorld& world, TickCallback::Place place) {
    return world.*(place == TickCallback::Place::before ? &Callbacks::m_internalPreTickCallback
                                                        : &Callbacks::m_internalTickCallback);
  }
};

}  // namespace

TickCallback::TickCallback(btDynamicsWorld& world, Place place, btInternalTickCallback ours)
    : world_(world), place_(place), ours_(ours) {
  stand();
}

bool TickCallback::stand() {
  const btInternalTickCallback standing = Callbacks::of(world_, place_);
  if (standing == ours_) return false;
  apps_ = standing;
  world_.setInternalTickCallback(ours_, world_.getWorldUserInfo(), place_ == Place::before);
  return true;
}

void TickCallback::give_back() {
  if (Callbacks::of(world_, place_) != ours_) return;
  world_.setInternalTickCallback(apps_, world_.getWorldUserInfo(), place_ == Place::before);
}

void TickCallback::call_apps(btScalar time_step) const {
  if (apps_ != nullptr) apps_(&world_, time_step);
}

}  // namespace softcd::bullet
