#pragma once

#include <vector>

#include "contacts/contact_writer.hpp"
#include "crossings/constrained_nodes.hpp"

/// What keeps the nodes of the deformable world from passing through faces: impacts that a continuous detection found
/// are answered by changes of velocity before the nodes move.
namespace softcd::bullet {

/// Two points about to meet: sum of weights[i] * x(nodes[i]) is the first minus the second.
struct Impact {
  Contact contact;        ///< as it was found
  btSoftBody* bodies[2];  ///< whose points these are
  btSoftBody::Node* nodes[4];
  const NodeConstraint* constraints[4] = {};  ///< of the nodes; null where they are free
  btScalar weights[4];
  btVector3 normal;  ///< from the second point towards the first
  btScalar friction;
};

Impact impact_of(const MemberContact& found);

/// Makes impacts inelastic, one after the other and repeatedly: afterwards the points of few pairs still approach each
/// other along their normal. No node without mass moves, nor any other in the directions of its constraint. Friction is
/// Bullet's (btSoftBody::applyRepulsionForce).
void apply_inelastic_impulses(const std::vector<Impact>& impacts);

/// Gives the points of impacts, by impulses along their normals, a `velocity` that moves them apart by this share of
/// where they are in a step. False where no node of theirs can give way. What touches when the step begins is left out:
/// its normal may be any.
bool set_apart(const std::vector<Impact>& impacts, btVector3 btSoftBody::Node::*velocity, btScalar share,
               btScalar time_step);

}  // namespace softcd::bullet
