#include "soft_world_hooks.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"

namespace softcd::bullet {
namespace {

// Brings the node trees up to date that Bullet's soft-rigid test is about to read: those of bodies whose boxes
// overlap a rigid one's.
void refit_read_node_trees(btOverlappingPairCache& pair_cache) {
  const btBroadphasePair* pairs = pair_cache.getOverlappingPairArrayPtr();
  btSoftBody* last_refitted = nullptr;
  for (int i = 0; i < pair_cache.getNumOverlappingPairs(); ++i) {
    auto* a = btSoftBody::upcast(static_cast<btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject));
    auto* b = btSoftBody::upcast(static_cast<btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject));
    if ((a == nullptr) == (b == nullptr)) continue;
    btSoftBody* soft = a != nullptr ? a : b;
    if (soft == last_refitted) continue;
    soft->updateNodeTree(/*use_velocity=*/false, /*margin=*/true);
    last_refitted = soft;
  }
}

}  // namespace

SoftWorldHooks::SoftWorldHooks(btDispatcher* dispatcher, const Settings& settings)
    : dispatcher_(dynamic_cast<Dispatcher*>(dispatcher)) {
  if (dispatcher_ != nullptr) return;
  detection_ = std::make_unique<SoftSoftDetection>(settings);
  if (auto* bullets = dynamic_cast<btCollisionDispatcher*>(dispatcher)) install_pair_recorder(*bullets);
}

void SoftWorldHooks::detect(btCollisionWorld& world, const btAlignedObjectArray<btSoftBody*>& bodies) {
  world.updateAabbs();
  world.computeOverlappingPairs();
  btOverlappingPairCache& pair_cache = *world.getPairCache();
  refit_read_node_trees(pair_cache);

  btDispatcher* dispatcher = world.getDispatcher();
  btDispatcherInfo& info = world.getDispatchInfo();
  if (detection_ == nullptr) {
    dispatcher->dispatchAllCollisionPairs(&pair_cache, info, dispatcher);
    return;
  }
  const PairGate gate(*dispatcher, pair_cache, info);
  const Span<btSoftBody* const> span =
      bodies.size() > 0 ? Span<btSoftBody* const>(&bodies[0], static_cast<std::size_t>(bodies.size()))
                        : Span<btSoftBody* const>();
  detection_->start(span, gate);
  {
    const FaceTreesOutOfSight out_of_sight(bodies);
    dispatcher->dispatchAllCollisionPairs(&pair_cache, info, dispatcher);
  }
  detection_->finish();
}

const Settings& SoftWorldHooks::settings() const {
  return dispatcher_ != nullptr ? dispatcher_->settings() : detection_->settings();
}

void SoftWorldHooks::set_settings(const Settings& settings) {
  if (dispatcher_ != nullptr) {
    dispatcher_->set_settings(settings);
  } else {
    detection_->set_settings(settings);
  }
}

const CollisionPipeline& SoftWorldHooks::pipeline() const {
  return dispatcher_ != nullptr ? dispatcher_->pipeline() : detection_->pipeline();
}

}  // namespace softcd::bullet
