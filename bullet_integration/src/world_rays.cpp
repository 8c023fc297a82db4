#include "world_rays.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <new>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"
#include "softcd/probe.hpp"

namespace softcd::bullet {
namespace {

/// What a ray comes near, by the broad phase.
class NearRay final : public btBroadphaseRayCallback {
 public:
  NearRay(const btVector3& from, const btVector3& to, btCollisionWorld::RayResultCallback& callback)
      : callback_(callback) {
    const btVector3 way = to - from;
    const btScalar length = way.length();
    for (int axis = 0; axis < 3; ++axis) {
      const btScalar component = length > 0 ? way[axis] / length : 0;
      m_rayDirectionInverse[axis] = component == 0 ? btScalar(1e30) : 1 / component;
      m_signs[axis] = m_rayDirectionInverse[axis] < 0 ? 1U : 0U;
    }
    m_lambda_max = length;
  }

  bool process(const btBroadphaseProxy* proxy) override {
    auto* object = static_cast<btCollisionObject*>(proxy->m_clientObject);
    if (!callback_.needsCollision(object->getBroadphaseHandle())) return true;
    btSoftBody* body = object->getCollisionShape()->isSoftBody() ? btSoftBody::upcast(object) : nullptr;
    if (body != nullptr) {
      soft_.push_back(body);
    } else {
      others_.push_back(object);
    }
    return true;
  }

  const std::vector<btSoftBody*>& soft() const { return soft_; }
  const std::vector<btCollisionObject*>& others() const { return others_; }

 private:
  btCollisionWorld::RayResultCallback& callback_;
  std::vector<btSoftBody*> soft_;
  std::vector<btCollisionObject*> others_;
};

btTransform at(const btVector3& origin) {
  return btTransform(btQuaternion::getIdentity(), origin);
}

Vec3d to_vec3(const btVector3& x) {
  return {double(x.x()), double(x.y()), double(x.z())};
}

}  // namespace

/// The bodies that rays have come near.
class WorldRays::Bodies {
 public:
  Bodies(RayTargets targets, const Settings& settings) : bodies_(targets, settings.log) {
    probe_.set_body_filter([this](BodyId id) { return std::find(near_.begin(), near_.end(), id) != near_.end(); });
  }

  /// Of the bodies that are near the first that the ray meets of each.
  void find_hits(Span<btSoftBody* const> near, const Ray& ray, std::vector<Hit>& hits) {
    near_.clear();
    for (btSoftBody* body : near) near_.push_back(bodies_.update(*body).id);
    const Span<const RayHit> met = probe_.all_hits({&ray, 1})[0];
    for (const RayHit& hit : met) {
      const SoftBodyScene::Member& member = *bodies_.find(hit.body);
      const bool is_new = std::none_of(hits.begin(), hits.end(), [&](const Hit& h) { return h.body == member.body; });
      if (is_new && hit.t > 0 && hit.t < 1) hits.push_back(described(member, hit, ray));
    }
  }

  void keep(Span<btSoftBody* const> all) { bodies_.keep(all); }

 private:
  static Hit described(const SoftBodyScene::Member& member, const RayHit& hit, const Ray& ray) {
    const btVector3 way(btScalar(ray.direction.x), btScalar(ray.direction.y), btScalar(ray.direction.z));
    if (hit.triangle >= member.mesh.triangles.size()) {
      const auto tetrahedron = static_cast<int>((hit.triangle - member.mesh.triangles.size()) / 4);
      return {member.body, btScalar(hit.t), -way.normalized(), tetrahedron};
    }
    btVector3 normal(btScalar(hit.normal.x), btScalar(hit.normal.y), btScalar(hit.normal.z));
    if (normal.dot(way) > 0) normal = -normal;
    return {member.body, btScalar(hit.t), normal, static_cast<int>(hit.triangle)};
  }

  SoftBodyScene bodies_;
  Probe probe_{bodies_.scene()};
  std::vector<BodyId> near_;  ///< the ray
};

WorldRays::WorldRays(RayTargets targets, const Settings& settings) : targets_(targets), settings_(settings) {}
WorldRays::~WorldRays() = default;

void WorldRays::set_settings(const Settings& settings) {
  bodies_.reset();
  settings_ = settings;
}

void WorldRays::test(btBroadphaseInterface& broadphase, Span<btSoftBody* const> bodies, const btVector3& from,
                     const btVector3& to, btCollisionWorld::RayResultCallback& callback,
                     const NativeTest& test_natively) {
  NearRay near(from, to, callback);
  broadphase.rayTest(from, to, near);
  const auto test_object = [&](btCollisionObject& object) {
    // Nothing is nearer than 0.
    if (callback.m_closestHitFraction != 0) test_natively(object, at(from), at(to));
  };
  for (btCollisionObject* object : near.others()) test_object(*object);
  std::vector<Hit> hits;
  if (near.soft().empty()) return;
  if (find_hits(near.soft(), bodies, segment(to_vec3(from), to_vec3(to)), hits)) {
    for (const Hit& hit : hits) report(hit, callback);
  } else {
    for (btSoftBody* body : near.soft()) test_object(*body);
  }
}

bool WorldRays::find_hits(Span<btSoftBody* const> near, Span<btSoftBody* const> all, const Ray& ray,
                          std::vector<Hit>& hits) {
  const std::lock_guard lock(mutex_);
  try {
    if (bodies_ == nullptr) bodies_ = std::make_unique<Bodies>(targets_, settings_);
    bodies_->keep(all);
    bodies_->find_hits(near, ray, hits);
    return true;
  } catch (const Error& error) {
    bodies_.reset();
    go_on(error.what());
  } catch (const std::bad_alloc&) {
    bodies_.reset();
    go_on("there is not enough memory");
  }
  return false;
}

/// While an exception is handled.
void WorldRays::go_on(const char* cause) {
  if (settings_.on_error == OnError::throw_error) throw;
  if (std::exchange(has_warned_, true) || !settings_.log) return;
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), "a ray test goes on as Bullet's own, of which nothing is said again: %s",
                cause);
  settings_.log(LogLevel::warning, text.data());
}

void WorldRays::report(const Hit& hit, btCollisionWorld::RayResultCallback& callback) {
  if (hit.fraction > callback.m_closestHitFraction) return;
  btCollisionWorld::LocalShapeInfo shape{};
  shape.m_shapePart = 0;
  shape.m_triangleIndex = hit.index;
  btCollisionWorld::LocalRayResult result(hit.body, &shape, hit.normal, hit.fraction);
  callback.addSingleResult(result, /*normalInWorldSpace=*/true);
}

}  // namespace softcd::bullet
