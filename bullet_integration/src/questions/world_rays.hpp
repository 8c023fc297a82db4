#pragma once

#include <cstdint>
#include <functional>
#include <memory_resource>
#include <shared_mutex>
#include <unordered_map>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "bodies/guarded.hpp"
#include "questions/ray_mesh.hpp"

namespace softcd::bullet {

/// Tests rays against a world's soft bodies where their nodes are now. Rays come one at a time, so each is traced on
/// the calling thread, in a hierarchy that the body keeps.
///
/// While nodes may move, every ray compares all nodes and triangles of the bodies that it comes near with what was
/// read. In between a ray looks at the bodies' sizes, bounds, and the triangles that it meets.
///
/// As Bullet's ray tests, from any number of threads at once, as long as nothing else changes the world.
class WorldRays {
 public:
  /// `settings` outlives it.
  WorldRays(RayTargets targets, const Settings& settings) : targets_(targets), settings_(settings) {}
  WorldRays(const WorldRays&) = delete;
  WorldRays& operator=(const WorldRays&) = delete;

  /// Nodes may move from now on, as they may before the first end_motion().
  void begin_motion() { may_move_ = true; }
  /// Nodes stay where they are until begin_motion().
  void end_motion() {
    may_move_ = false;
    ++revision_;
  }
  /// The app has moved nodes, or changed triangles, since the last ray.
  void forget_positions() { ++revision_; }

  /// Bullet's own test of one object.
  using NativeTest = std::function<void(btCollisionObject&, const btTransform& from, const btTransform& to)>;

  /// btCollisionWorld::rayTest, of a world with these soft bodies. Of each soft body the callback is told the first
  /// face that the ray meets: part 0, triangle index as in m_faces (or m_tetras), normal towards the ray's origin. All
  /// else, and everything where softcd fails, is tested natively.
  void test(btBroadphaseInterface& broadphase, Span<btSoftBody* const> bodies, const btVector3& from,
            const btVector3& to, btCollisionWorld::RayResultCallback& callback, const NativeTest& test_natively);

 private:
  struct Hit {
    btSoftBody* body;
    double t;
    btVector3 normal;
    int index;  ///< of the face, or of the tetrahedron
  };
  using Hits = std::pmr::vector<Hit>;
  struct Member {
    RayMesh mesh;
    std::uint64_t revision = 0;  ///< at which it was read last
    int proxy_id = 0;            ///< of its broad-phase proxy then: another body may have come to its address
  };

  /// False where softcd has failed, and the settings say to go on.
  bool find_hits(Span<btSoftBody* const> near, Span<btSoftBody* const> all, const Ray& ray, Hits& hits);
  /// False where a body is not as it was read, which is known of bodies that were read just now.
  bool find_hits_as_read(Span<btSoftBody* const> near, const Ray& ray, bool is_read_now, Hits& hits) const;
  bool is_as_read(const Member& member, const btSoftBody& body) const;
  void read(Span<btSoftBody* const> near, Span<btSoftBody* const> all);
  static Hit described(btSoftBody& body, const RayMesh& mesh, const RayHit& hit, const Ray& ray);
  static void report(const Hit& hit, btCollisionWorld::RayResultCallback& callback);

  RayTargets targets_;
  const Settings& settings_;
  bool may_move_ = true;
  std::uint64_t revision_ = 1;
  std::unordered_map<const btSoftBody*, Member> members_;  ///< bodies that rays have come near
  std::shared_mutex mutex_;                                ///< of the members and failures
  Failures failures_{"a ray test goes on as Bullet's own"};
};

/// A time in which nodes may move.
class NodesInMotion {
 public:
  explicit NodesInMotion(WorldRays& rays) : rays_(rays) { rays.begin_motion(); }
  NodesInMotion(const NodesInMotion&) = delete;
  NodesInMotion& operator=(const NodesInMotion&) = delete;
  ~NodesInMotion() { rays_.end_motion(); }

 private:
  WorldRays& rays_;
};

}  // namespace softcd::bullet
