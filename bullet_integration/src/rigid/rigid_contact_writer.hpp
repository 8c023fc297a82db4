#pragma once

#include "BulletSoftBody/btSoftBody.h"

/// Contacts with rigid objects in Bullet's own arrays, with the formulas of CollideSDF_RS, CollideSDF_RD and
/// CollideSDF_RDF in btSoftBodyInternals.h.
namespace softcd::bullet {

/// Least weight of a face's node. With a smaller one the point counts as on the edge, or at the corner, of the other
/// nodes.
inline constexpr btScalar kLeastWeight = btScalar(1e-4);

/// A contact of a soft body with a rigid object.
struct RigidTouch {
  const btCollisionObject* object;
  btVector3 normal;  ///< unit vector from the object towards the soft body
  btScalar margin;
  btVector3 object_point_t0, object_point_t1;
  float time_of_impact;
};

/// Returns the distance along the normal minus the margin at one end of the step; negative within the margin.
inline btScalar depth(const RigidTouch& touch, const btVector3& soft_point, const btVector3& object_point) {
  return touch.normal.dot(soft_point - object_point) - touch.margin;
}

/// Writes a node's contact in classic worlds, where the node has moved from m_q to m_x.
void write_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch);

/// Does the same for a point on a face. Bullet has no such contact, so each node with a weight gets one, by its weight.
/// If the nodes approach at one velocity, the point stops as a node would. A face that turns about the point is slowed
/// down, because each of its nodes is stopped separately.
void write_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch);

/// Writes a node's contact in the deformable world, where the node is about to move from m_x to m_q.
void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch);

/// Does the same for a point on a face, with Bullet's own kind of contact.
void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights,
                                    const RigidTouch& touch);

}  // namespace softcd::bullet
