#pragma once

#include <unordered_map>
#include <vector>

#include "bodies/node_ends.hpp"
#include "crossings/velocity_response.hpp"
#include "softcd/core/types.hpp"

namespace softcd::bullet {

class RigidMotion;

/// Nodes that impacts connect move on as one rigid body (impact zones, Provot 1997; Bridson et al. 2002): with the
/// velocity and the angular velocity of their common momentum, or with those of nodes that others move where a zone has
/// such. All ways are straight, so that a zone's nodes go through affine images of where they were, none of which is
/// singular: nothing within a zone can meet. Of velocities v(i) = V + w x r(i), momentum and angular momentum are
/// those of before, and kinetic energy is the least for them.
class ImpactZones {
 public:
  /// `start` is where the nodes are when the step begins, which takes `time_step`.
  ImpactZones(NodePosition start, btScalar time_step) : start_(start), time_step_(double(time_step)) {}

  /// Joins each impact's nodes into one zone. False when all were in one zone already.
  bool join(const std::vector<Impact>& impacts);
  /// In the deformable world split velocities become one motion apart: they end with the step.
  void move_as_one();

 private:
  using Node = btSoftBody::Node;

  Node* root_of(Node* node);
  void move_as_one(const std::vector<Node*>& zone, btVector3 Node::*velocity) const;
  void keep_within_constraints(const std::vector<Node*>& zone, btVector3 Node::*velocity, RigidMotion& motion) const;
  Vec3d place_of(const Node& node) const;
  const NodeConstraint* constraint_of(const Node& node) const { return constraints_.at(&node); }
  bool is_prescribed(const Node& node) const { return is_moved_by_others(node, constraint_of(node)); }

  NodePosition start_;
  double time_step_;
  std::unordered_map<Node*, Node*> parents_;
  std::unordered_map<const Node*, const NodeConstraint*> constraints_;
  std::vector<Node*> nodes_;  ///< the keys in the order in which they came
};

}  // namespace softcd::bullet
