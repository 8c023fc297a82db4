#pragma once

#include <functional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "rigid/mesh_ways.hpp"

namespace softcd::bullet {

/// The other objects of the world for crossing prevention.
struct Surroundings {
  const btCollisionObjectArray* objects = nullptr;                ///< null if there are none
  std::function<bool(btSoftBody&, btCollisionObject&)> collides;  ///< whether Bullet lets them collide
  Span<btSoftBody* const> soft_bodies;                            ///< the world's; a moved body can meet them
};

/// Rigid triangle meshes in crossing prevention: the pieces of meshes that soft bodies can meet in a step. Each is
/// represented by a proxy, one of RigidProxies in the mirror. Owned by CrossingPrevention.
class RigidObstacles {
 public:
  /// `mirror` must outlive it.
  explicit RigidObstacles(WorldMirror& mirror) : mirror_(mirror), proxies_(mirror.rigid().proxies) {}
  ~RigidObstacles() { proxies_.clear(); }
  RigidObstacles(const RigidObstacles&) = delete;
  RigidObstacles& operator=(const RigidObstacles&) = delete;

  void keep_starts(const btCollisionObjectArray& objects, btScalar time_step) { ways_.keep_starts(objects, time_step); }
  /// Returns whether the last step and this one had no proxies.
  bool empty() const { return proxies_.bodies().size() == 0; }
  bool has(const btSoftBody& body) const { return partners_.count(&body) != 0; }
  /// Returns the object that the body represents, or the body itself if it is no proxy.
  const btCollisionObject& object_of(const btSoftBody& body) const;
  /// Returns the rigid body that the proxy represents if impulses can move it, otherwise null.
  btRigidBody* free_body_of(const btSoftBody& proxy) const;
  /// Returns whether a proxy and a soft body, in any order, may collide.
  bool collide(const btSoftBody& a, const btSoftBody& b) const;

  /// Puts the pieces of meshes that these bodies can meet on their paths into the mirror, with both ends of their own
  /// paths. `surroundings` must live until end_step(), or the next call.
  void begin_step(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step);
  /// Adds the pieces that the bodies can meet on their changed paths.
  void follow(Span<btSoftBody* const> bodies);
  /// Puts the rigid body back where the step began, for good in this step. Returns false if that was done before.
  bool hold(btRigidBody& body);
  /// Stops the held bodies: what they met in this step cannot give way.
  void stop_held() const;
  /// Undoes hold().
  void release_held();
  void end_step();

 private:
  using Partners = std::unordered_set<const btSoftBody*>;
  /// A mesh of this step, with its pieces. It needs further ones if bodies are moved beyond the first one.
  struct Mesh {
    MeshWay way;
    std::vector<RigidProxies::Piece*> pieces = {};
  };
  struct Reach {
    btSoftBody* body;
    Bounds box;
  };

  bool is_covered(const Mesh& mesh, const btSoftBody& body, const Bounds& box) const;
  void add_piece(Mesh& mesh, const std::vector<Reach>& reaches);

  WorldMirror& mirror_;
  RigidProxies& proxies_;
  MeshWays ways_;
  std::unordered_map<const btSoftBody*, Partners> partners_;  ///< of this step's proxies
  // Members of this step:
  Surroundings surroundings_;
  btScalar time_step_ = 0;
  std::vector<Mesh> meshes_;
  std::unordered_map<btRigidBody*, btTransform> held_;  ///< with the ends of their paths without responses
};

}  // namespace softcd::bullet
