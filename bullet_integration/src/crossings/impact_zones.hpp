#pragma once

#include <unordered_map>
#include <vector>

#include "bodies/node_ends.hpp"
#include "crossings/velocity_response.hpp"
#include "softcd/core/types.hpp"

namespace softcd::bullet {

class RigidMotion;

/// Moves nodes that impacts connect as one rigid body (impact zones; Provot 1997; Bridson, Fedkiw and Anderson 2002). A
/// zone has the velocity and angular velocity of its nodes' common momentum. If it has prescribed nodes (massless or
/// anchored ones), it follows their motion.
///
/// All paths are straight, so a zone's nodes pass through affine images of their start. None of these is singular, so
/// features within a zone cannot meet. The velocities v(i) = V + w x r(i) keep momentum and angular momentum, and have
/// the least kinetic energy for these.
class ImpactZones {
 public:
  /// `start` is the member with the nodes' positions at the start of the step, which takes `time_step`.
  ImpactZones(NodePosition start, btScalar time_step) : start_(start), time_step_(double(time_step)) {}

  /// Joins each impact's nodes into one zone. Returns false if this changes nothing.
  bool join(const std::vector<Impact>& impacts);
  /// Gives each zone one motion. In the deformable world split velocities, which end with the step, become one motion
  /// separately.
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
  std::vector<Node*> nodes_;  ///< the keys in the order of their insertion
};

}  // namespace softcd::bullet
