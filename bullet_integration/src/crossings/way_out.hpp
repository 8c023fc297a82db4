#pragma once

#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "crossings/crossing_impulses.hpp"
#include "crossings/crossings_of_kind.hpp"

class btRigidBody;

namespace softcd::bullet {

/// A direction in which nodes of intersecting bodies move together, such as a node and the nodes of the face that it
/// moves to. One side may be a rigid object. The directions add up to 0, so that equal impulses along them keep the
/// momentum.
struct WayOut {
  struct End {
    BodyId body;
    std::uint32_t node;
    btVector3 direction;  ///< times the node's weight; the longest of a way has length 1
  };
  /// The sum of ends at points of a rigid object.
  struct RigidEnd {
    const btCollisionObject* object = nullptr;  ///< null if the way has none
    btVector3 direction{0, 0, 0};
    btVector3 turn{0, 0, 0};  ///< sum of arm x direction; arms begin at the object's centre
    btScalar reach = 0;       ///< the longest arm
    btScalar motion = 0;      ///< along the way, in the step without any response

    void add(const btVector3& direction_at_point, const btVector3& arm, const btVector3& motion_of_point);
  };
  std::vector<End> ends;
  RigidEnd rigid;
  btScalar distance = 0;  ///< sum of direction * motion over the ends with which the bodies are apart
  btScalar speed = 0;     ///< greatest one of a node
};

/// Changes the nodes' and rigid bodies' ends of a step so that they go at least as far along each way as its speed
/// allows in the step, or to its end. An approach against the way stops like in an inelastic impact. The rest is a
/// shift, which gives no velocity. Nodes that are massless, anchored or of sleeping bodies do not move, nor do static
/// and kinematic objects. Untangling makes one for each step.
class NodesOnWaysOut {
 public:
  /// `objects` are the world's. impulses() is empty unless `notes_impulses`.
  NodesOnWaysOut(const CrossingsOfKind& kind, const WorldMirror& mirror, const btCollisionObjectArray& objects,
                 bool notes_impulses)
      : kind_(kind), mirror_(mirror), objects_(objects), notes_impulses_(notes_impulses) {}

  void move(const std::vector<WayOut>& ways, btScalar time_step);
  /// Returns what move() has given to nodes.
  const std::vector<CrossingImpulse>& impulses() const { return impulses_; }

 private:
  struct Moved {
    const btSoftBody* body;
    btSoftBody::Node* node;
    btVector3 direction;
    btVector3 start;
    btScalar inverse_mass;
  };
  /// A rigid object with its changes of place. Static and kinematic ones, and links, have no body.
  struct Rigid {
    bool is_in_world = false;
    btRigidBody* body = nullptr;
    btVector3 shift{0, 0, 0}, turn{0, 0, 0};
  };
  /// The motion of a rigid end by an impulse of 1 along its way.
  struct RigidResponse {
    Rigid* rigid = nullptr;  ///< null if nothing moves
    btVector3 linear{0, 0, 0}, angular{0, 0, 0};
  };
  bool look_up(const WayOut& way);
  void hold_anchored(const btSoftBody& body);
  Rigid& rigid_of(const btCollisionObject& object);
  void move_along(const WayOut& way, btScalar time_step);
  void note_impulse(const WayOut& way, const Moved& moved, const btVector3& change);
  void place_rigid_bodies();

  const CrossingsOfKind& kind_;
  const WorldMirror& mirror_;
  const btCollisionObjectArray& objects_;
  bool notes_impulses_;
  std::unordered_map<const btCollisionObject*, Rigid> rigid_;
  std::unordered_set<const btSoftBody*> seen_;
  std::unordered_set<const btSoftBody::Node*> anchored_;
  std::vector<Moved> moved_;  ///< of one way
  RigidResponse response_;    ///< of the same way
  std::vector<CrossingImpulse> impulses_;
};

}  // namespace softcd::bullet
