#include "world_rays.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <new>
#include <unordered_map>
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

constexpr std::uint32_t kTetrahedronFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};

/// The sides of all tetrahedra, four each.
std::vector<Triangle> tetrahedron_faces(const btSoftBody& body) {
  std::vector<Triangle> triangles;
  triangles.reserve(4 * static_cast<std::size_t>(body.m_tetras.size()));
  for (int i = 0; i < body.m_tetras.size(); ++i) {
    for (const auto& corners : kTetrahedronFaces) {
      Triangle triangle{};
      for (int corner = 0; corner < 3; ++corner) {
        triangle.v[corner] = static_cast<std::uint32_t>(body.m_tetras[i].m_n[corners[corner]] - &body.m_nodes[0]);
      }
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

bool has_same_corners(const Triangle& a, const Triangle& b) {
  return std::equal(a.v, a.v + 3, b.v);
}

}  // namespace

/// The bodies that rays have come near, in a scene.
class WorldRays::Bodies {
 public:
  Bodies(RayTargets targets, const Settings& settings) : targets_(targets), scene_(options(), settings.log) {}

  /// Of the bodies that are near the first that the ray meets of each.
  void find_hits(Span<btSoftBody* const> near, const Ray& ray, std::vector<Hit>& hits) {
    ++call_;
    for (btSoftBody* body : near) update(*body);
    for (const RayHit& hit : probe_.all_hits({&ray, 1})[0]) {
      const Member& member = *members_by_id_.at(hit.body.value);
      const bool is_new = std::none_of(hits.begin(), hits.end(), [&](const Hit& h) { return h.body == member.body; });
      if (is_new && hit.t > 0 && hit.t < 1) hits.push_back(described(member, hit, ray));
    }
  }

  /// Forgets bodies that are not in the world any more, once there are some.
  void keep(Span<btSoftBody* const> all) {
    if (members_.size() <= all.size()) return;
    for (auto entry = members_.begin(); entry != members_.end();) {
      if (std::find(all.begin(), all.end(), entry->first) != all.end()) {
        ++entry;
        continue;
      }
      scene_.remove_body(entry->second.id);
      members_by_id_.erase(entry->second.id.value);
      entry = members_.erase(entry);
    }
  }

 private:
  struct Member {
    btSoftBody* body = nullptr;
    BodyId id;
    BodyMesh mesh;
    std::vector<Triangle> tetrahedron_faces;  ///< behind the mesh's triangles
    std::vector<Vec3<btScalar>> positions;
    std::uint64_t last_call = 0;  ///< in which a ray came near it
  };

  static SceneOptions options() {
    SceneOptions options;
    options.backend = Backend::cpu;
    return options;
  }

  void update(btSoftBody& body) {
    std::vector<Triangle> tetrahedra;
    if (targets_ == RayTargets::faces_and_tetrahedra) tetrahedra = tetrahedron_faces(body);
    Member& member = members_[&body];
    const bool is_known = member.body != nullptr;
    member.last_call = call_;
    if (!is_known || !is_up_to_date(member.mesh, body) ||
        !std::equal(tetrahedra.begin(), tetrahedra.end(), member.tetrahedron_faces.begin(),
                    member.tetrahedron_faces.end(), has_same_corners)) {
      set_mesh(member, body, std::move(tetrahedra));
    }
    update_positions(member, body);
  }

  void set_mesh(Member& member, btSoftBody& body, std::vector<Triangle> tetrahedra) {
    BodyMesh mesh = read_mesh(body);
    std::vector<Triangle> triangles = mesh.triangles;
    triangles.insert(triangles.end(), tetrahedra.begin(), tetrahedra.end());
    const BodyDesc desc = {triangles, mesh.node_count, {}};
    if (member.body == nullptr) {
      member.id = scene_.add_body(desc);
      members_by_id_[member.id.value] = &member;
    } else {
      scene_.update_body(member.id, desc);
    }
    member.body = &body;
    member.mesh = std::move(mesh);
    member.tetrahedron_faces = std::move(tetrahedra);
    member.positions.clear();
  }

  void update_positions(Member& member, const btSoftBody& body) {
    const auto count = static_cast<std::size_t>(body.m_nodes.size());
    bool has_moved = member.positions.size() != count;
    member.positions.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const btVector3& x = body.m_nodes[static_cast<int>(i)].m_x;
      const Vec3<btScalar> now{x.x(), x.y(), x.z()};
      has_moved |= !(member.positions[i] == now);
      member.positions[i] = now;
    }
    if (has_moved && count > 0) scene_.set_positions(member.id, member.positions);
  }

  Hit described(const Member& member, const RayHit& hit, const Ray& ray) const {
    const btVector3 way(btScalar(ray.direction.x), btScalar(ray.direction.y), btScalar(ray.direction.z));
    if (hit.triangle >= member.mesh.triangles.size()) {
      const auto tetrahedron = static_cast<int>((hit.triangle - member.mesh.triangles.size()) / 4);
      return {member.body, btScalar(hit.t), -way.normalized(), tetrahedron};
    }
    btVector3 normal(btScalar(hit.normal.x), btScalar(hit.normal.y), btScalar(hit.normal.z));
    if (normal.dot(way) > 0) normal = -normal;
    return {member.body, btScalar(hit.t), normal, static_cast<int>(hit.triangle)};
  }

  RayTargets targets_;
  Scene scene_;
  Probe probe_ = near_probe();
  std::unordered_map<const btSoftBody*, Member> members_;
  std::unordered_map<std::uint32_t, const Member*> members_by_id_;
  std::uint64_t call_ = 0;

  Probe near_probe() {
    Probe probe(scene_);
    probe.set_body_filter([this](BodyId id) { return members_by_id_.at(id.value)->last_call == call_; });
    return probe;
  }
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
