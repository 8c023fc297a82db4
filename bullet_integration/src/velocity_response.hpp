#pragma once

#include <unordered_map>
#include <vector>

#include "contact_writer.hpp"

/// What keeps the nodes of the deformable world from passing through faces: impacts that a continuous detection found
/// are answered by changes of velocity before the nodes move.
namespace softcd::bullet {

/// Two points about to meet: sum of weights[i] * x(nodes[i]) is the first minus the second.
struct Impact {
  btSoftBody* bodies[2];  ///< whose points these are
  btSoftBody::Node* nodes[4];
  btScalar weights[4];
  btVector3 normal;  ///< from the second point towards the first
  btScalar friction;
  bool is_from_start;  ///< they touch when the step begins
};

Impact impact_of(const MemberContact& found);

/// Makes impacts inelastic, one after the other and repeatedly: afterwards the points of few pairs still approach each
/// other along their normal. Nodes that Bullet's solver has constrained (by rigid contacts, anchors, infinite mass) do
/// not move. Friction is Bullet's (btSoftBody::applyRepulsionForce).
void apply_inelastic_impulses(const std::vector<Impact>& impacts);

/// The last resort (rigid impact zones, Provot 1997, without their rotation): nodes that impacts connect move on with
/// one velocity, that of their common momentum, and so cannot meet.
class ImpactZones {
 public:
  /// Joins each impact's nodes into one zone. False when all were in one zone already.
  bool join(const std::vector<Impact>& impacts);
  /// In the deformable world split velocities are averaged apart: they end with the step.
  void move_as_one();

 private:
  using Node = btSoftBody::Node;

  Node* root_of(Node* node);
  void average(btVector3 Node::*velocity);

  std::unordered_map<Node*, Node*> parents_;
  std::vector<Node*> nodes_;  ///< the keys in the order in which they came
};

}  // namespace softcd::bullet
