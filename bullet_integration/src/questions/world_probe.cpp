#include "softcd/bullet/world_probe.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"
#include "BulletSoftBody/btSoftRigidDynamicsWorld.h"
#include "bodies/convex_core.hpp"
#include "bodies/vectors.hpp"
#include "questions/contact_test.hpp"
#include "questions/world_rays.hpp"

namespace softcd::bullet {
namespace {

/// Passes on Bullet's contacts between rigid objects.
class OfRigidObjects final : public btCollisionWorld::ContactResultCallback {
 public:
  explicit OfRigidObjects(btCollisionWorld::ContactResultCallback& callback) : callback_(callback) {
    m_closestDistanceThreshold = callback.m_closestDistanceThreshold;
  }
  bool needsCollision(btBroadphaseProxy* proxy) const override {
    return btSoftBody::upcast(static_cast<btCollisionObject*>(proxy->m_clientObject)) == nullptr &&
           callback_.needsCollision(proxy);
  }
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int part_a, int index_a,
                           const btCollisionObjectWrapper* b, int part_b, int index_b) override {
    return callback_.addSingleResult(point, a, part_a, index_a, b, part_b, index_b);
  }

 private:
  btCollisionWorld::ContactResultCallback& callback_;
};

}  // namespace

ShapeHull::ShapeHull(const btConvexShape& shape, const btTransform& place)
    : radius_(std::max(0.0, double(shape.getMarginNonVirtual()))) {
  ConvexCore core;
  core.read(shape);
  points_.reserve(core.vertices().size());
  for (const btVector3& corner : core.vertices()) points_.push_back(to_doubles(place * corner));
}

struct WorldProbe::Implementation {
  Implementation(btCollisionWorld& asked, LogCallback log)
      : world(asked),
        settings(settings_with(std::move(log))),
        rays(dynamic_cast<btDeformableMultiBodyDynamicsWorld*>(&asked) != nullptr ? RayTargets::faces
                                                                                  : RayTargets::faces_and_tetrahedra,
             settings),
        bodies(kPresentEnds, settings),
        probe(bodies.scene()) {}

  static Settings settings_with(LogCallback log) {
    Settings settings;
    settings.log = std::move(log);
    settings.on_error = OnError::throw_error;
    settings.backend = Backend::cpu;
    settings.self_collision = SelfCollision::none;
    settings.rigid_meshes = false;
    return settings;
  }

  void test(btCollisionObject& object, const std::vector<btCollisionObject*>& others,
            btCollisionWorld::ContactResultCallback& callback) {
    bodies.resume_step(all_soft_bodies());
    test_contacts(bodies, object, others, callback);
  }

  std::vector<btSoftBody*> all_soft_bodies() const {
    std::vector<btSoftBody*> all;
    for (btCollisionObject* object : span_of(world.getCollisionObjectArray())) {
      if (btSoftBody* const soft = btSoftBody::upcast(object)) all.push_back(soft);
    }
    return all;
  }

  btCollisionWorld& world;
  Settings settings;
  WorldRays rays;
  WorldMirror bodies;
  Probe probe;
};

WorldProbe::WorldProbe(btCollisionWorld& world, LogCallback log)
    : implementation_(std::make_unique<Implementation>(world, std::move(log))) {}
WorldProbe::~WorldProbe() = default;
WorldProbe::WorldProbe(WorldProbe&&) noexcept = default;
WorldProbe& WorldProbe::operator=(WorldProbe&&) noexcept = default;

Probe& WorldProbe::soft_bodies() {
  const std::vector<btSoftBody*> all = implementation_->all_soft_bodies();
  implementation_->bodies.resume_step(all);
  for (btSoftBody* body : all) implementation_->bodies.require(*body, /*needs_way=*/false);
  return implementation_->probe;
}

BodyId WorldProbe::body_id(const btSoftBody& body) const {
  if (!implementation_->bodies.has(body)) {
    throw InvalidInput("a soft body was not in the world when soft_bodies() was called last; call it again.");
  }
  return implementation_->bodies.member(body).id;
}

btSoftBody* WorldProbe::soft_body(BodyId body) const {
  const WorldMirror::Member* const member = implementation_->bodies.find(body);
  return member != nullptr ? member->body : nullptr;
}

void WorldProbe::ray_test(const btVector3& from, const btVector3& to, btCollisionWorld::RayResultCallback& callback) {
  implementation_->rays.test(*implementation_->world.getBroadphase(), implementation_->all_soft_bodies(), from, to,
                             callback, btSoftRigidDynamicsWorld::rayTestSingle);
}

void WorldProbe::contact_test(btCollisionObject& object, btCollisionWorld::ContactResultCallback& callback) {
  btCollisionWorld& world = implementation_->world;
  const bool is_soft = btSoftBody::upcast(&object) != nullptr;
  if (!is_soft) {
    OfRigidObjects of_rigid_objects(callback);
    world.contactTest(&object, of_rigid_objects);
  }
  std::vector<btCollisionObject*> others;
  for (btCollisionObject* other : span_of(world.getCollisionObjectArray())) {
    const bool is_asked = other != &object && (is_soft || btSoftBody::upcast(other) != nullptr);
    if (is_asked && callback.needsCollision(other->getBroadphaseHandle())) others.push_back(other);
  }
  implementation_->test(object, others, callback);
}

void WorldProbe::contact_pair_test(btCollisionObject& a, btCollisionObject& b,
                                   btCollisionWorld::ContactResultCallback& callback) {
  if (btSoftBody::upcast(&a) == nullptr && btSoftBody::upcast(&b) == nullptr) {
    implementation_->world.contactPairTest(&a, &b, callback);
  } else {
    implementation_->test(a, {&b}, callback);
  }
}

}  // namespace softcd::bullet
