#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "soft_body_scene.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// Tests rays against a world's soft bodies where their nodes are now. Rays come one at a time, so that this is done on
/// the CPU. What an app may have done to a body is noticed whenever a ray comes near it. As Bullet's ray tests, from
/// any number of threads at once, as long as nothing else changes the world.
class WorldRays {
 public:
  WorldRays(RayTargets targets, const Settings& settings);
  ~WorldRays();
  WorldRays(const WorldRays&) = delete;
  WorldRays& operator=(const WorldRays&) = delete;

  void set_settings(const Settings& settings);

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
    btScalar fraction;
    btVector3 normal;
    int index;  ///< of the face, or of the tetrahedron
  };
  class Bodies;

  /// False where softcd has failed, and the settings say to go on.
  bool find_hits(Span<btSoftBody* const> near, Span<btSoftBody* const> all, const Ray& ray, std::vector<Hit>& hits);
  void go_on(const char* cause);
  static void report(const Hit& hit, btCollisionWorld::RayResultCallback& callback);

  RayTargets targets_;
  Settings settings_;
  std::unique_ptr<Bodies> bodies_;  ///< null until a ray comes near one, and after a failure
  std::mutex mutex_;                ///< of all but what set_settings() changes
  bool has_warned_ = false;
};

}  // namespace softcd::bullet
