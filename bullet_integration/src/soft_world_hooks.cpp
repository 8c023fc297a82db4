#include "soft_world_hooks.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"

namespace softcd::bullet {

SoftWorldHooks::SoftWorldHooks(btDispatcher* dispatcher, const Settings& settings)
    : dispatcher_(dynamic_cast<Dispatcher*>(dispatcher)), settings_(settings), prevention_(kClassicWorld, settings) {
  if (dispatcher_ != nullptr) return;
  detection_ = std::make_unique<ContactDetection>(kClassicWorld, settings);
  mesh_detection_ = std::make_unique<RigidMeshDetection>(kClassicWorld, settings);
  if (auto* bullets = dynamic_cast<btCollisionDispatcher*>(dispatcher)) install_pair_recorder(*bullets);
}

void SoftWorldHooks::detect(btCollisionWorld& world, const btAlignedObjectArray<btSoftBody*>& bodies) {
  world.updateAabbs();
  if (settings().rigid_meshes) {
    for (btSoftBody* body : span_of(bodies)) sweep_box(*body, *world.getBroadphase(), world.getDispatcher());
  }
  world.computeOverlappingPairs();
  btOverlappingPairCache& pair_cache = *world.getPairCache();
  for_each_near_rigid(pair_cache,
                      [](btSoftBody& body) { body.updateNodeTree(/*use_velocity=*/false, /*margin=*/true); });

  btDispatcher* dispatcher = world.getDispatcher();
  btDispatcherInfo& info = world.getDispatchInfo();
  if (detection_ == nullptr) {
    dispatcher->dispatchAllCollisionPairs(&pair_cache, info, dispatcher);
    return;
  }
  const PairGate gate(*dispatcher, pair_cache, info);
  detection_->start(span_of(bodies), pair_rule(kClassicWorld, gate, settings_));
  {
    const TreesOutOfSight out_of_sight(bodies, &btSoftBody::m_fdbvt);
    mesh_detection_->around(*dispatcher, info,
                            [&] { dispatcher->dispatchAllCollisionPairs(&pair_cache, info, dispatcher); });
  }
  detection_->finish();
}

void SoftWorldHooks::prevent_crossings(btCollisionWorld& world, const btAlignedObjectArray<btSoftBody*>& bodies,
                                       btScalar time_step) {
  if (settings().detection != Detection::ccd) return;
  if (dispatcher_ != nullptr) prevention_.set_settings(settings());
  const PairGate gate(*world.getDispatcher(), *world.getPairCache(), world.getDispatchInfo());
  prevention_.run(span_of(bodies), pair_rule(kClassicWorld, gate, settings()), time_step);
}

const Settings& SoftWorldHooks::settings() const {
  return dispatcher_ != nullptr ? dispatcher_->settings() : settings_;
}

void SoftWorldHooks::set_settings(const Settings& settings) {
  if (dispatcher_ != nullptr) {
    dispatcher_->set_settings(settings);
  } else {
    detection_->set_settings(settings);
    mesh_detection_->set_settings(settings);
  }
  prevention_.set_settings(settings);
  settings_ = settings;
}

const CollisionPipeline& SoftWorldHooks::pipeline() const {
  return dispatcher_ != nullptr ? dispatcher_->pipeline() : detection_->pipeline();
}

const std::vector<EdgeContact>& SoftWorldHooks::edge_contacts() const {
  return dispatcher_ != nullptr ? dispatcher_->edge_contacts() : detection_->edge_contacts();
}

}  // namespace softcd::bullet
