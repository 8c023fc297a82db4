#pragma once

#include "BulletSoftBody/btSoftBody.h"

/// Contacts with rigid objects in Bullet's own arrays, with the formulas of CollideSDF_RS, CollideSDF_RD and
/// CollideSDF_RDF in btSoftBodyInternals.h.
namespace softcd::bullet {

/// Of a face's node: below, a point counts as one on the edge, or at the corner, of the others.
inline constexpr btScalar kLeastWeight = btScalar(1e-4);

/// Where a soft body touches a rigid object.
struct RigidTouch {
  const btCollisionObject* object;
  btVector3 normal;  ///< unit vector from the object towards the soft body
  btScalar margin;
  btVector3 object_point_t0, object_point_t1;
  float time_of_impact;
};

/// Whether the body's point is closer than the margin at this end of the step.
inline btScalar depth(const RigidTouch& touch, const btVector3& soft_point, const btVector3& object_point) {
  return touch.normal.dot(soft_point - object_point) - touch.margin;
}

/// Classic worlds, where the node has moved from m_q to m_x.
void write_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch);

/// The same for a point on a face: a contact of each of its nodes, by its weight, none of which Bullet has a place for.
/// Where the nodes come at one velocity the point stops as a node would; a face that turns about the point is slowed
/// down, as each of its nodes is stopped for itself.
void write_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch);

/// Deformable world, where the node is about to move from m_x to m_q.
void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch);

/// The same for a point on a face: Bullet's own kind of contact.
void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights,
                                    const RigidTouch& touch);

}  // namespace softcd::bullet
