#include "worlds/attached_world.hpp"

#include <typeinfo>
#include <utility>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"

namespace softcd::bullet {

AttachedWorld::AttachedWorld(btDynamicsWorld& world, const SoftBodies& bodies, const WorldKind& kind,
                             const Settings& settings)
    : world_(&world),
      collision_world_(world),
      bodies_(bodies),
      detection_(kind, settings),
      broadphase_(*world.getBroadphase(), *this),
      pre_tick_(world, call_pre_tick),
      tick_(world, call_tick),
      sees_pairs_(dynamic_cast<btCollisionDispatcherMt*>(world.getDispatcher()) == nullptr) {
  queries().broadphase = [this] { return world_ != nullptr ? world_->getBroadphase() : nullptr; };
  world.setBroadphase(&broadphase_);
}

AttachedWorld* AttachedWorld::of(btDynamicsWorld& world) {
  const auto* broadphase = dynamic_cast<const HookedBroadphase*>(world.getBroadphase());
  return broadphase != nullptr ? static_cast<AttachedWorld*>(&broadphase->hooks()) : nullptr;
}

/// The app's callback may detach, and so destroy the attachment, which is therefore looked up again.
void AttachedWorld::call_pre_tick(btDynamicsWorld* world, btScalar time_step) {
  if (AttachedWorld* attached = of(*world)) {
    if (attached->ends_steps_late()) attached->finish_step();
    attached->start_over();
    if (const auto apps = attached->pre_tick_.apps()) apps(world, time_step);
  }
  if (AttachedWorld* attached = of(*world)) attached->before_prediction();
}

void AttachedWorld::call_tick(btDynamicsWorld* world, btScalar time_step) {
  if (AttachedWorld* attached = of(*world)) {
    if (const auto apps = attached->tick_.apps()) apps(world, time_step);
  }
  if (AttachedWorld* attached = of(*world)) attached->before_solver(time_step);
}

/// Resets the state of the last step, which an exception may have left in the middle.
void AttachedWorld::start_over() {
  face_trees_.give_back();
  stage_ = Stage::none;
  step().begin();
}

void AttachedWorld::before_prediction() {
  queries().massless_paths.find_moves(bodies());
  hide_tree_flags(bodies(), queries().kind().tree_flag);
  stage_ = Stage::begun;
}

void AttachedWorld::before_pairs() {
  restore_tree_flags(bodies(), queries().kind().tree_flag);
  tick_.stand();
  if (pre_tick_.stand()) begin_without_tick();
  if (stage_ == Stage::begun) step().pairs();
}

/// Begins a step after the app has replaced softcd's tick callback by its own.
void AttachedWorld::begin_without_tick() {
  const bool has_end_to_come = ends_steps_late() && is_solved();
  start_over();
  stage_ = Stage::begun;
  if (!has_end_to_come || queries().settings().detection != Detection::ccd) return;
  queries().crossings.run([](CrossingPrevention&) {
    throw Error("the app has set a tick callback before the step was finished; call finish_step() first");
  });
}

void AttachedWorld::process_pairs(const Processing& process_natively) {
  if (stage_ == Stage::begun) {
    process(process_natively);
    stage_ = Stage::has_pairs;
  } else {
    process_natively();
    queries().forget_algorithms();
  }
}

void AttachedWorld::before_solver(btScalar time_step) {
  if (stage_ == Stage::begun) miss_pairs();
  if (stage_ != Stage::has_pairs) return;
  prepare_solver();
  time_step_ = time_step;
  stage_ = Stage::is_solved;
}

void AttachedWorld::miss_pairs() {
  if (std::exchange(sees_pairs_, false)) {
    const Settings& settings = queries().settings();
    const auto fail = [](auto& /*detection*/) {
      throw Error("the world's dispatcher does not process pairs through the pair cache");
    };
    if (settings.rigid_meshes) queries().rigid_meshes.run(fail);
    if (settings.convex_shapes != ConvexShapes::nodes) queries().convex_shapes.run(fail);
  }
  process_late();
  stage_ = Stage::has_pairs;
}

void AttachedWorld::finish_step() {
  if (stage_ != Stage::is_solved) return;
  stage_ = Stage::none;
  end_step(time_step_);
}

void AttachedWorld::detach() {
  if (world_ == nullptr) return;
  remove_hooks();
  restore_tree_flags(bodies(), queries().kind().tree_flag);
  try {
    finish_step();
  } catch (...) {
    leave_world();
    throw;
  }
  leave_world();
}

void AttachedWorld::remove_hooks() {
  if (world_->getBroadphase() == &broadphase_) world_->setBroadphase(&broadphase_.original());
  pre_tick_.give_back();
  tick_.give_back();
}

void AttachedWorld::leave_world() {
  queries().massless_paths.take_starts_back(bodies());
  face_trees_.give_back();
  forget_rigid_algorithms(*world_->getPairCache(), *world_->getDispatcher());
  for (btSoftBody* body : bodies()) give_face_tree(*body);
  world_ = nullptr;
}

/// During its destruction a world calls this for its objects when it is only a btCollisionWorld any more.
void AttachedWorld::before_removal(const btCollisionObject& object) {
  if (auto* body = const_cast<btSoftBody*>(btSoftBody::upcast(&object))) {
    restore_flag(*body, queries().kind().tree_flag);
    face_trees_.give_back(*body);
  }
  if (typeid(collision_world_) == typeid(btCollisionWorld)) {
    world_ = nullptr;
    stage_ = Stage::none;
  }
}

}  // namespace softcd::bullet
