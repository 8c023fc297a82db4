#include "softcd/bullet/dispatcher.hpp"

#include "contact_detection.hpp"
#include "rigid_mesh_detection.hpp"

namespace softcd::bullet {
namespace {

// Bullet's part of the pairs: everything but the vertex-face pairs of soft bodies.
class NativePairs : public btOverlapCallback {
 public:
  NativePairs(btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) : dispatcher_(dispatcher), info_(info) {}

  bool processOverlap(btBroadphasePair& pair) override {
    const auto* a = btSoftBody::upcast(static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject));
    const auto* b = btSoftBody::upcast(static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject));
    const bool ours = a != nullptr && b != nullptr && is_vertex_face_pair(kClassicWorld, *a, *b);
    if (!ours) dispatcher_.getNearCallback()(pair, dispatcher_, info_);
    return false;
  }

 private:
  btCollisionDispatcher& dispatcher_;
  const btDispatcherInfo& info_;
};

}  // namespace

Dispatcher::Dispatcher(btCollisionConfiguration* configuration, Broadphase& broadphase, const Settings& settings)
    : btCollisionDispatcher(configuration),
      broadphase_(broadphase),
      settings_(settings),
      detection_(std::make_unique<ContactDetection>(kClassicWorld, settings)),
      mesh_detection_(std::make_unique<RigidMeshDetection>(kClassicWorld, settings)) {
  install_pair_recorder(*this);
  broadphase_.hide_vertex_face_flags();
  broadphase_.sweep_boxes(settings.rigid_meshes);
}

Dispatcher::~Dispatcher() = default;

void Dispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pair_cache, const btDispatcherInfo& info,
                                           btDispatcher* dispatcher) {
  if (pair_cache != broadphase_.getOverlappingPairCache()) {
    btCollisionDispatcher::dispatchAllCollisionPairs(pair_cache, info, dispatcher);
    return;
  }
  broadphase_.restore_vertex_face_flags();
  const PairGate gate(*this, *pair_cache, info);
  detection_->start(broadphase_.soft_bodies(), pair_rule(kClassicWorld, gate, settings_));
  NativePairs native_pairs(*this, info);
  mesh_detection_->around(*this, info,
                          [&] { pair_cache->processAllOverlappingPairs(&native_pairs, dispatcher, info); });
  detection_->drop_unread_face_trees();
  detection_->finish();
}

const Settings& Dispatcher::settings() const {
  return settings_;
}

void Dispatcher::set_settings(const Settings& settings) {
  detection_->set_settings(settings);
  mesh_detection_->set_settings(settings);
  broadphase_.sweep_boxes(settings.rigid_meshes);
  settings_ = settings;
}

const CollisionPipeline& Dispatcher::pipeline() const {
  return detection_->pipeline();
}

const std::vector<EdgeContact>& Dispatcher::edge_contacts() const {
  return detection_->edge_contacts();
}

}  // namespace softcd::bullet
