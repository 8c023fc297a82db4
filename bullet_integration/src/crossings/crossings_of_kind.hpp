#pragma once

#include <unordered_map>
#include <vector>

#include "bodies/node_ends.hpp"
#include "crossings/impact_zones.hpp"

namespace softcd::bullet {

/// The bodies whose nodes' velocities were changed so that they do not pass through each other, with what their nodes
/// had before.
struct NodeStates {
  std::vector<btVector3> velocities, split_velocities, ends;
};
using AnsweredBodies = std::unordered_map<btSoftBody*, NodeStates>;

/// What differs between the kinds of world in the prevention of crossings.
struct CrossingsOfKind {
  const NodeEnds& ends;

  /// What CrossingPrevention does to a body: before it looks for the first time; before it answers an impact of the
  /// body for the first time; and after each change of velocities, to bring the nodes' `end` to where these lead.
  void (*set_out)(btSoftBody&, btScalar time_step);
  void (*take_up)(btSoftBody&, btScalar time_step);
  void (*move_end)(btSoftBody&, btScalar time_step);
  /// Of a node, what moves its `end` in this step alone, and is gone when the ends stand.
  btVector3 btSoftBody::Node::*passing_velocity;
  /// By what a node's mean velocity in the step, or its own in the deformable world, has changed: what
  /// BodyContact::impulse_a counts.
  btVector3 (*velocity_change)(const btSoftBody::Node&, const NodeStates& before, std::size_t index,
                               btScalar time_step);
  /// After move_end: to leave a node where the step began, with its velocity.
  void (*hold)(btSoftBody::Node&);
  /// And to all of them when the ends stand: `impacts` and `zones` are those that were answered.
  void (*settle)(const AnsweredBodies&, const std::vector<Impact>& impacts, ImpactZones& zones);
};

extern const CrossingsOfKind kClassicCrossings, kDeformableCrossings;

}  // namespace softcd::bullet
