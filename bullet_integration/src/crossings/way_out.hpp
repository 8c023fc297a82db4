#pragma once

#include <unordered_set>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "crossings/crossings_of_kind.hpp"

namespace softcd::bullet {

/// A direction in which nodes of intersecting bodies move together, such as a node and the nodes of the face that it
/// moves to. The directions add up to 0, so that equal impulses along them keep the momentum.
struct WayOut {
  struct End {
    BodyId body;
    std::uint32_t node;
    btVector3 direction;  ///< times the node's weight; the longest of a way has length 1
  };
  std::vector<End> ends;
  btScalar distance = 0;  ///< sum of direction * motion over the ends with which the bodies are apart
};

/// Changes the nodes' ends of a step so that they go at least as far along each way as Settings::untangle_speed allows
/// in the step, or to its end. An approach against the way stops like in an inelastic impact. The rest is a shift,
/// which gives the nodes no velocity. Nodes that are massless, anchored or of sleeping bodies do not move.
class NodesOnWaysOut {
 public:
  NodesOnWaysOut(const CrossingsOfKind& kind, const WorldMirror& mirror) : kind_(kind), mirror_(mirror) {}

  void move(const std::vector<WayOut>& ways, btScalar greatest_shift, btScalar time_step);

 private:
  struct Moved {
    btSoftBody::Node* node;
    btVector3 direction;
    btVector3 start;
    btScalar inverse_mass;
  };
  bool look_up(const WayOut& way);
  void hold_anchored(const btSoftBody& body);

  const CrossingsOfKind& kind_;
  const WorldMirror& mirror_;
  std::unordered_set<const btSoftBody*> seen_;
  std::unordered_set<const btSoftBody::Node*> anchored_;
  std::vector<Moved> moved_;  ///< of one way
};

}  // namespace softcd::bullet
