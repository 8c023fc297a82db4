#pragma once

#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "rigid/mesh_ways.hpp"
#include "rigid/rigid_mesh.hpp"

namespace softcd::bullet {

/// The other objects of the world for crossing prevention.
struct Surroundings {
  const btCollisionObjectArray* objects = nullptr;                ///< null if there are none
  std::function<bool(btSoftBody&, btCollisionObject&)> collides;  ///< whether Bullet lets them collide
};

/// Rigid triangle meshes in crossing prevention, each represented by a proxy body: a soft body of massless nodes that
/// is in no world. Proxies are in the mirror beside the soft bodies. Responses to impacts need to know only that the
/// app moves them. Each proxy has the part of a mesh that soft bodies can meet in a step.
class RigidObstacles {
 public:
  /// `ends` and `mirror` must outlive it.
  RigidObstacles(const NodeEnds& ends, WorldMirror& mirror) : ends_(ends), mirror_(mirror) {}

  void keep_starts(const btCollisionObjectArray& objects, btScalar time_step) { ways_.keep_starts(objects, time_step); }
  /// Returns the proxies of the last step and of this one.
  Span<btSoftBody* const> proxies() const { return {proxies_.data(), proxies_.size()}; }
  bool has(const btSoftBody& body) const { return partners_.count(&body) != 0; }
  /// Returns the object that the body represents, or the body itself if it is no proxy.
  const btCollisionObject& object_of(const btSoftBody& body) const;
  /// Returns whether a proxy and a soft body, in any order, may collide.
  bool collide(const btSoftBody& a, const btSoftBody& b) const;

  /// Puts the parts of meshes that these bodies can meet on their paths into the mirror, with both ends of their own
  /// paths. `surroundings` must live until end_step(), or the next call.
  void begin_step(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step);
  /// Adds the parts that the bodies can meet on their changed paths.
  void follow(Span<btSoftBody* const> bodies);
  void end_step();

 private:
  /// Identifies a part: object, shape, number of the mesh within the object, number of the part within the mesh. A step
  /// needs further parts if bodies are moved beyond the first one.
  using Key = std::tuple<BodyKey, const btConcaveShape*, int, int>;
  using Partners = std::unordered_set<const btSoftBody*>;
  struct Part {
    RigidMesh mesh;
    std::unique_ptr<btSoftBody> proxy;
    bool is_present = false;
  };
  /// A mesh of this step, with its parts.
  struct Mesh {
    MeshWay way;
    std::vector<const Part*> parts = {};
  };
  struct Reach {
    btSoftBody* body;
    RigidBox box;
  };

  void remove_absent();
  bool is_covered(const Mesh& mesh, const btSoftBody& body, const RigidBox& box) const;
  void add_part(Mesh& mesh, const std::vector<Reach>& reaches);
  void place(Part& part, const MeshWay& way) const;

  const NodeEnds& ends_;
  WorldMirror& mirror_;
  MeshWays ways_;
  std::map<Key, Part> parts_;
  int last_proxy_ = 0;
  std::vector<btSoftBody*> proxies_;                          ///< of all parts
  std::unordered_map<const btSoftBody*, Partners> partners_;  ///< of this step's proxies
  // Members of this step:
  Surroundings surroundings_;
  btScalar time_step_ = 0;
  std::vector<Mesh> meshes_;
};

}  // namespace softcd::bullet
