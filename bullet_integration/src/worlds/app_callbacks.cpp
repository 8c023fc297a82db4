#include "worlds/app_callbacks.hpp"

namespace softcd::bullet {
namespace {

using DeformableWorldOfBullet = btDeformableMultiBodyDynamicsWorld;

// Bullet has functions to set callbacks, but none to read them. The app's own must still be called.

struct Callbacks : btDynamicsWorld {
  static btInternalTickCallback of(btDynamicsWorld& world, bool is_pre_tick) {
    return world.*(is_pre_tick ? &Callbacks::m_internalPreTickCallback : &Callbacks::m_internalTickCallback);
  }
};

SolverPlace::Function solver_callback_of(const DeformableWorldOfBullet& world);

/// The member is private; an explicit instantiation may name it.
template <SolverPlace::Function DeformableWorldOfBullet::*kMember>
struct Reader {
  friend SolverPlace::Function solver_callback_of(const DeformableWorldOfBullet& world) { return world.*kMember; }
};
template struct Reader<&DeformableWorldOfBullet::m_solverCallback>;

}  // namespace

template <bool kIsPreTick>
btInternalTickCallback TickPlace<kIsPreTick>::read(btDynamicsWorld& world) {
  return Callbacks::of(world, kIsPreTick);
}
template struct TickPlace<true>;
template struct TickPlace<false>;

SolverPlace::Function SolverPlace::read(World& world) {
  return solver_callback_of(world);
}

}  // namespace softcd::bullet
