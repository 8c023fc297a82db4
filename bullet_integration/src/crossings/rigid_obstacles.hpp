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

/// What else there is in the world of a look at crossings.
struct Surroundings {
  const btCollisionObjectArray* objects = nullptr;                ///< null: nothing
  std::function<bool(btSoftBody&, btCollisionObject&)> collides;  ///< whether they do in Bullet
};

/// Rigid triangle meshes as the look at crossings sees them: soft bodies of nodes without mass, in no world, which
/// stand in the mirror beside the others. Who answers an impact with one needs to know no more than that others move
/// it. Each is the part of a mesh that the soft bodies can meet in a step.
class RigidObstacles {
 public:
  /// `ends` and `mirror` outlive it.
  RigidObstacles(const NodeEnds& ends, WorldMirror& mirror) : ends_(ends), mirror_(mirror) {}

  void keep_starts(const btCollisionObjectArray& objects, btScalar time_step) { ways_.keep_starts(objects, time_step); }
  /// Those of the last step and this one's.
  Span<btSoftBody* const> stand_ins() const { return {stand_ins_.data(), stand_ins_.size()}; }
  bool has(const btSoftBody& body) const { return partners_.count(&body) != 0; }
  /// The object whose stand-in the body is; else the body.
  const btCollisionObject& object_of(const btSoftBody& body) const;
  /// Of bodies one of which is a stand-in.
  bool collide(const btSoftBody& a, const btSoftBody& b) const;

  /// Puts in the mirror, with both ends of their ways, what these bodies can meet on theirs. `surroundings` are there
  /// until end_step(), or the next call.
  void begin_step(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step);
  /// And what they can meet now, on other ways.
  void follow(Span<btSoftBody* const> bodies);
  void end_step();

 private:
  /// A mesh by its object, its shape, and its number among the object's meshes; and among the parts of it, of which a
  /// step has more than one where bodies are sent beyond the first.
  using Key = std::tuple<const btCollisionObject*, const btConcaveShape*, int, int>;
  using Partners = std::unordered_set<const btSoftBody*>;
  struct Part {
    RigidMesh mesh;
    std::unique_ptr<btSoftBody> stand_in;
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
  std::vector<btSoftBody*> stand_ins_;                        ///< of all parts
  std::unordered_map<const btSoftBody*, Partners> partners_;  ///< of the stand-ins of this step
  // Of this step:
  Surroundings surroundings_;
  btScalar time_step_ = 0;
  std::vector<Mesh> meshes_;
};

}  // namespace softcd::bullet
