#pragma once

#include <cstdint>
#include <limits>
#include <unordered_set>
#include <utility>
#include <vector>

#include "bodies/node_ends.hpp"
#include "crossings/impact_zones.hpp"

namespace softcd::bullet {

/// A body's nodes before the responses of a step.
struct NodeStates {
  std::vector<btVector3> velocities, split_velocities, ends;
};

/// The bodies that got responses in a step, in the order of their first ones. So sums over them are the same in every
/// run.
class AnsweredBodies {
 public:
  /// Returns the entry of a new body, which the next call may move, or null if the body has one.
  NodeStates* add(btSoftBody& body) {
    return known_.insert(&body).second ? &bodies_.emplace_back(&body, NodeStates()).second : nullptr;
  }
  bool has(const btSoftBody& body) const { return known_.count(&body) != 0; }
  void clear() {
    bodies_.clear();
    known_.clear();
  }
  auto begin() const { return bodies_.begin(); }
  auto end() const { return bodies_.end(); }

 private:
  std::vector<std::pair<btSoftBody*, NodeStates>> bodies_;
  std::unordered_set<const btSoftBody*> known_;
};

/// The number of rounds after which each stronger response to impacts starts: zones after `impulses` (as many as
/// Bullet's own loop in the deformable world tries), single held nodes after `zones`, whole held bodies after `nodes`.
/// The search ends after `last`.
struct AnswerRounds {
  std::uint64_t impulses = 5;
  std::uint64_t zones = 25;
  std::uint64_t nodes = 40;
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
};

/// The differences between the kinds of world in the prevention of crossings, and its constants.
struct CrossingsOfKind {
  const NodeEnds& ends;

  /// Called by CrossingPrevention for a body: set_out() before its first query, take_up() before its first response to
  /// an impact of the body, move_end() after each change of velocities, to move the nodes' ends accordingly.
  void (*set_out)(btSoftBody&, btScalar time_step);
  void (*take_up)(btSoftBody&, btScalar time_step);
  void (*move_end)(btSoftBody&, btScalar time_step);
  /// The velocity of a node that moves its end in this step only.
  btVector3 btSoftBody::Node::*passing_velocity;
  /// Returns the change of a node's velocity that BodyPairContacts::impulse_a counts: of the mean velocity in the step,
  /// or in the deformable world of its own.
  btVector3 (*velocity_change)(const btSoftBody::Node&, const NodeStates& before, std::size_t index,
                               btScalar time_step);
  /// Changes a node's velocity and its end accordingly, and shifts the end in this step alone. Returns the change as
  /// velocity_change() counts it.
  btVector3 (*push)(btSoftBody::Node&, const btVector3& velocity, const btVector3& shift, btScalar time_step);
  /// Limits how far responses stretch links: see link_stretch.hpp. Returns whether velocities have changed.
  bool (*limit_stretch)(const AnsweredBodies&, btScalar time_step);
  /// Holds a node where the step began, with its velocity; after move_end().
  void (*hold)(btSoftBody::Node&);
  /// Called once for all bodies when the ends are final. `impacts` and `zones` are those with a response. Returns
  /// whether Bullet will move nodes by velocities that do not lead to their ends exactly.
  bool (*finish)(const AnsweredBodies&, const std::vector<Impact>& impacts, ImpactZones& zones, btScalar time_step);
  AnswerRounds rounds = {};
  /// Whether Untangle::automatic also parts soft bodies that intersect from the start.
  bool parts_soft_bodies_from_start;
};

extern const CrossingsOfKind kClassicCrossings, kDeformableCrossings;

}  // namespace softcd::bullet
