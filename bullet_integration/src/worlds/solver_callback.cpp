#include "worlds/solver_callback.hpp"

namespace softcd::bullet {
namespace {

using World = btDeformableMultiBodyDynamicsWorld;

SolverCallback::Function standing_in(const World& world);

/// Bullet has a function to set the callback, and none to ask for the one that is set. An app's own must go on being
/// called. The member is private; an explicit instantiation may name it.
template <SolverCallback::Function World::*kMember>
struct Reader {
  friend SolverCallback::Function standing_in(const World& world) { return world.*kMember; }
};
template struct Reader<&World::m_solverCallback>;

}  // namespace

SolverCallback::SolverCallback(World& world, Function ours) : world_(world), ours_(ours) {
  stand();
}

void SolverCallback::stand() {
  const Function standing = standing_in(world_);
  if (standing == ours_) return;
  apps_ = standing;
  world_.setSolverCallback(ours_);
}

void SolverCallback::give_back() {
  if (standing_in(world_) == ours_) world_.setSolverCallback(apps_);
}

void SolverCallback::call_apps(btScalar time) const {
  if (apps_ != nullptr) apps_(time, &world_);
}

}  // namespace softcd::bullet
