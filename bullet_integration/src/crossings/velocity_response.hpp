#pragma once

#include <vector>

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "contacts/contact_writer.hpp"
#include "crossings/constrained_nodes.hpp"

/// Responses to impacts that a continuous detection found: changes of velocity before the nodes move.
namespace softcd::bullet {

/// Two points about to meet. The sum of weights[i] * x(nodes[i]) is the first point minus the second.
struct Impact {
  Contact contact;        ///< as detected
  btSoftBody* bodies[2];  ///< the bodies of the two points
  btSoftBody::Node* nodes[4];
  const NodeConstraint* constraints[4] = {};  ///< of the nodes; null for free nodes
  btScalar weights[4];
  btVector3 normal;  ///< from the second point towards the first
  btScalar friction;
  btRigidBody* rigid = nullptr;  ///< the body with mass whose mesh has one of the points; null if there is none
  btScalar rigid_sign = 0;       ///< 1 if that is the first point, -1 if it is the second one
};

Impact impact_of(const MemberContact& found);

/// Whether impulses also change the velocities of rigid bodies. They do not while the last pass changes positions: by
/// then Bullet has moved the rigid bodies to the step's end.
enum class RigidResponse { none, impulses };

/// Makes impacts inelastic, one after the other and repeatedly, until few pairs of points still approach each other
/// along their normal. Massless nodes do not move, and constrained nodes do not move in their constraints' directions.
/// Friction is Bullet's (btSoftBody::applyRepulsionForce).
void apply_inelastic_impulses(const std::vector<Impact>& impacts, RigidResponse rigid = RigidResponse::none);

/// Moves the points of impacts apart by impulses along their normals, which change the member `velocity`. In this step
/// the points separate by `share` of their largest coordinate. Returns false if no node can move. Leaves out features
/// that touch at the start of the step: their normal is arbitrary.
bool set_apart(const std::vector<Impact>& impacts, btVector3 btSoftBody::Node::*velocity, btScalar share,
               btScalar time_step);

}  // namespace softcd::bullet
