#pragma once

#include <cstdint>
#include <functional>
#include <memory_resource>
#include <mutex>
#include <shared_mutex>
#include <unordered_map>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "bodies/body_key.hpp"
#include "bodies/guarded.hpp"
#include "questions/ray_mesh.hpp"

namespace softcd::bullet {

/// Tests rays against a world's soft bodies at their nodes' present positions. Rays come one at a time. So each is
/// traced on the calling thread, in a hierarchy that is kept for the body.
///
/// While nodes may move, every ray compares all nodes and triangles of nearby bodies with those read last. Otherwise a
/// ray compares the bodies' sizes and bounds, and the triangles that it hits. Usable from any number of threads at
/// once, as long as nothing else changes the world. Owned by WorldQueries, or by a WorldProbe.
class WorldRays {
 public:
  /// `settings` must outlive it.
  WorldRays(RayTargets targets, const Settings& settings) : targets_(targets), settings_(settings) {}
  WorldRays(const WorldRays&) = delete;
  WorldRays& operator=(const WorldRays&) = delete;

  /// Nodes may move from now on. This also holds before the first end_motion().
  void begin_motion() { may_move_ = true; }
  /// Nodes do not move until begin_motion().
  void end_motion() {
    may_move_ = false;
    ++revision_;
  }
  /// Makes the next ray read bodies again, after the app has moved nodes or changed triangles.
  void forget_positions() { ++revision_; }

  /// A world's rayTestSingle(), Bullet's own test of one object.
  using NativeTest = std::function<decltype(btCollisionWorld::rayTestSingle)>;

  /// Does btCollisionWorld::rayTest for a world with these soft bodies. For each soft body the callback gets the first
  /// face that the ray hits: part 0, triangle index as in m_faces (or m_tetras), normal towards the ray's origin. Other
  /// objects are tested natively; so are soft bodies if softcd fails.
  void test(btBroadphaseInterface& broadphase, Span<btSoftBody* const> bodies, const btVector3& from,
            const btVector3& to, btCollisionWorld::RayResultCallback& callback, const NativeTest& test_natively);

 private:
  struct Hit {
    btSoftBody* body;
    double t;
    btVector3 normal;
    int index;  ///< of the face or the tetrahedron
  };
  using Hits = std::pmr::vector<Hit>;
  struct Member {
    RayMesh mesh;
    std::uint64_t revision = 0;  ///< when it was last read
  };

  /// Returns false if softcd has failed and the settings say to continue.
  bool find_hits(Span<btSoftBody* const> nearby, Span<btSoftBody* const> all, const Ray& ray, Hits& hits);
  /// Returns false if a body has changed since it was read. Bodies that were read just now have not.
  bool find_hits_as_read(Span<btSoftBody* const> nearby, const Ray& ray, bool is_read_now, Hits& hits) const;
  bool is_as_read(const Member& member, const btSoftBody& body) const;
  void read(Span<btSoftBody* const> nearby, Span<btSoftBody* const> all);
  static Hit described(btSoftBody& body, const RayMesh& mesh, const RayHit& hit, const Ray& ray);
  static void report(const Hit& hit, btCollisionWorld::RayResultCallback& callback);

  RayTargets targets_;
  const Settings& settings_;
  bool may_move_ = true;
  std::uint64_t revision_ = 1;
  std::unordered_map<BodyKey, Member, BodyKeyHash> members_;  ///< bodies that rays have come near
  std::shared_mutex mutex_;                                   ///< protects the members and failures
  /// A btDbvtBroadphase of a Bullet without BT_THREADSAFE tests all rays with one stack.
  std::mutex broadphase_mutex_;
  Failures failures_{"the ray test is Bullet's own"};
};

}  // namespace softcd::bullet
