#include "questions/world_rays.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

/// Collects the objects that a ray comes near, by the broad phase.
class NearRay final : public btBroadphaseRayCallback {
 public:
  NearRay(const btVector3& from, const btVector3& to, std::pmr::memory_resource& memory) : objects_(&memory) {
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
    objects_.push_back(static_cast<btCollisionObject*>(proxy->m_clientObject));
    return true;
  }

  const std::pmr::vector<btCollisionObject*>& objects() const { return objects_; }

 private:
  std::pmr::vector<btCollisionObject*> objects_;
};

/// Returns the segment without its ends.
Ray open_segment(const btVector3& from, const btVector3& to) {
  Ray ray = segment(to_doubles(from), to_doubles(to));
  ray.t_min = 0x1p-1074;
  ray.t_max = 1.0 - 0x1p-53;
  return ray;
}

}  // namespace

void WorldRays::test(btBroadphaseInterface& broadphase, Span<btSoftBody* const> bodies, const btVector3& from,
                     const btVector3& to, btCollisionWorld::RayResultCallback& callback,
                     const NativeTest& test_natively) {
  std::array<std::byte, 2048> buffer;  // enough for a ray near few objects
  std::pmr::monotonic_buffer_resource memory(buffer.data(), buffer.size());
  NearRay nearby(from, to, memory);
  {
    const std::lock_guard lock(broadphase_mutex_);
    broadphase.rayTest(from, to, nearby);
  }
  const btTransform begin(btQuaternion::getIdentity(), from);
  const btTransform end(btQuaternion::getIdentity(), to);
  const auto test_object = [&](btCollisionObject& object) {
    // No hit is nearer than 0.
    if (callback.m_closestHitFraction == 0) return;
    test_natively(begin, end, &object, object.getCollisionShape(), object.getWorldTransform(), callback);
  };
  std::pmr::vector<btSoftBody*> soft(&memory);
  for (btCollisionObject* object : nearby.objects()) {
    if (!callback.needsCollision(object->getBroadphaseHandle())) continue;
    btSoftBody* body = object->getCollisionShape()->isSoftBody() ? btSoftBody::upcast(object) : nullptr;
    if (body != nullptr) {
      soft.push_back(body);
    } else {
      test_object(*object);
    }
  }
  if (soft.empty()) return;
  Hits hits(&memory);
  hits.reserve(soft.size());
  if (find_hits(soft, bodies, open_segment(from, to), hits)) {
    for (const Hit& hit : hits) report(hit, callback);
  } else {
    for (btSoftBody* body : soft) test_object(*body);
  }
}

bool WorldRays::find_hits(Span<btSoftBody* const> nearby, Span<btSoftBody* const> all, const Ray& ray, Hits& hits) {
  {
    const std::shared_lock lock(mutex_);
    if (find_hits_as_read(nearby, ray, /*is_read_now=*/false, hits)) return true;
  }
  const std::lock_guard lock(mutex_);
  try {
    read(nearby, all);
    return find_hits_as_read(nearby, ray, /*is_read_now=*/true, hits);
  } catch (...) {
    members_.clear();
    failures_.note(settings_);
    return false;
  }
}

bool WorldRays::find_hits_as_read(Span<btSoftBody* const> nearby, const Ray& ray, bool is_read_now, Hits& hits) const {
  hits.clear();
  for (btSoftBody* body : nearby) {
    const auto found = members_.find(BodyKey(*body));
    if (!is_read_now && (found == members_.end() || !is_as_read(found->second, *body))) return false;
    const RayMesh& mesh = found->second.mesh;
    const RayHit hit = mesh.first_hit(ray);
    if (!hit.has_hit()) continue;
    if (!is_read_now && !mesh.is_up_to_date(*body, hit.triangle)) return false;
    const auto is_before = [](double t, const Hit& other) { return t < other.t; };
    hits.insert(std::upper_bound(hits.begin(), hits.end(), hit.t, is_before), described(*body, mesh, hit, ray));
  }
  return true;
}

bool WorldRays::is_as_read(const Member& member, const btSoftBody& body) const {
  if (may_move_) return member.mesh.is_up_to_date(body);
  return member.revision == revision_ && member.mesh.seems_up_to_date(body);
}

void WorldRays::read(Span<btSoftBody* const> nearby, Span<btSoftBody* const> all) {
  if (members_.size() > all.size()) {
    std::erase_if(members_, [&](const auto& member) {
      return std::none_of(all.begin(), all.end(), [&](const auto* body) { return BodyKey(*body) == member.first; });
    });
  }
  for (const btSoftBody* body : nearby) {
    Member& member = members_.try_emplace(BodyKey(*body), Member{RayMesh(targets_)}).first->second;
    member.mesh.update(*body);
    member.revision = revision_;
  }
}

WorldRays::Hit WorldRays::described(btSoftBody& body, const RayMesh& mesh, const RayHit& hit, const Ray& ray) {
  const btVector3 way = to_bullet(ray.direction);
  if (hit.triangle >= mesh.face_count()) {
    return {&body, hit.t, -way.normalized(), static_cast<int>((hit.triangle - mesh.face_count()) / 4)};
  }
  const btVector3 normal = to_bullet(vec3_cast<double>(hit.normal));
  return {&body, hit.t, normal.dot(way) > 0 ? -normal : normal, static_cast<int>(hit.triangle)};
}

void WorldRays::report(const Hit& hit, btCollisionWorld::RayResultCallback& callback) {
  const auto fraction = static_cast<btScalar>(hit.t);
  if (fraction > callback.m_closestHitFraction) return;
  btCollisionWorld::LocalShapeInfo shape{};
  shape.m_shapePart = 0;
  shape.m_triangleIndex = hit.index;
  btCollisionWorld::LocalRayResult result(hit.body, &shape, hit.normal, fraction);
  callback.addSingleResult(result, /*normalInWorldSpace=*/true);
}

}  // namespace softcd::bullet
