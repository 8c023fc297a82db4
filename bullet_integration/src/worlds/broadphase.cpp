#include "softcd/bullet/broadphase.hpp"

#include <algorithm>
#include <utility>

#include "BulletSoftBody/btSoftBody.h"
#include "native/native_trees.hpp"
#include "worlds/step_driver.hpp"

namespace softcd::bullet {

Broadphase::Broadphase(std::unique_ptr<btBroadphaseInterface> original)
    : owned_(std::move(original)), original_(*owned_) {}

Broadphase::Broadphase(btBroadphaseInterface& original) : original_(original) {}

Broadphase::~Broadphase() = default;

void Broadphase::attach(const Settings& settings) {
  settings_ = &settings;
  for (btSoftBody* body : soft_bodies_) hide_flag(*body, kClassicTreeFlag);
}

void Broadphase::detach() {
  settings_ = nullptr;
  restore_vertex_face_flags();
}

void Broadphase::restore_vertex_face_flags() {
  restore_tree_flags(soft_bodies_, kClassicTreeFlag);
}

btBroadphaseProxy* Broadphase::createProxy(const btVector3& aabb_min, const btVector3& aabb_max, int shape_type,
                                           void* user, int filter_group, int filter_mask, btDispatcher* dispatcher) {
  if (shape_type == SOFTBODY_SHAPE_PROXYTYPE) {
    if (btSoftBody* body = btSoftBody::upcast(static_cast<btCollisionObject*>(user))) {
      soft_bodies_.push_back(body);
      if (settings_ != nullptr) hide_flag(*body, kClassicTreeFlag);
    }
  }
  return original_.createProxy(aabb_min, aabb_max, shape_type, user, filter_group, filter_mask, dispatcher);
}

void Broadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  const auto position = std::find(soft_bodies_.begin(), soft_bodies_.end(), proxy->m_clientObject);
  if (position != soft_bodies_.end()) {
    restore_flag(**position, kClassicTreeFlag);
    soft_bodies_.erase(position);
  }
  original_.destroyProxy(proxy, dispatcher);
}

void Broadphase::setAabb(btBroadphaseProxy* proxy, const btVector3& aabb_min, const btVector3& aabb_max,
                         btDispatcher* dispatcher) {
  original_.setAabb(proxy, aabb_min, aabb_max, dispatcher);
}

void Broadphase::getAabb(btBroadphaseProxy* proxy, btVector3& aabb_min, btVector3& aabb_max) const {
  original_.getAabb(proxy, aabb_min, aabb_max);
}

void Broadphase::rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
                         const btVector3& aabb_min, const btVector3& aabb_max) {
  original_.rayTest(from, to, callback, aabb_min, aabb_max);
}

void Broadphase::aabbTest(const btVector3& aabb_min, const btVector3& aabb_max, btBroadphaseAabbCallback& callback) {
  original_.aabbTest(aabb_min, aabb_max, callback);
}

void Broadphase::calculateOverlappingPairs(btDispatcher* dispatcher) {
  if (settings_ != nullptr) sweep_boxes(soft_bodies_, *settings_, original_, dispatcher);
  original_.calculateOverlappingPairs(dispatcher);
}

btOverlappingPairCache* Broadphase::getOverlappingPairCache() {
  return original_.getOverlappingPairCache();
}

const btOverlappingPairCache* Broadphase::getOverlappingPairCache() const {
  return std::as_const(original_).getOverlappingPairCache();
}

void Broadphase::getBroadphaseAabb(btVector3& aabb_min, btVector3& aabb_max) const {
  original_.getBroadphaseAabb(aabb_min, aabb_max);
}

void Broadphase::resetPool(btDispatcher* dispatcher) {
  original_.resetPool(dispatcher);
}

void Broadphase::printStats() {
  original_.printStats();
}

}  // namespace softcd::bullet
