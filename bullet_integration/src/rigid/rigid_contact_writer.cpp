#include "rigid/rigid_contact_writer.hpp"

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"
#include "BulletSoftBody/btSoftBodyInternals.h"

namespace softcd::bullet {
namespace {

/// The data of a rigid object for the formulas. Objects that are no btRigidBody do not move.
struct RigidSide {
  btRigidBody* body;
  btScalar inverse_mass = 0;
  btMatrix3x3 inverse_inertia{0, 0, 0, 0, 0, 0, 0, 0, 0};
  btVector3 origin;

  explicit RigidSide(const btCollisionObject& object)
      : body(const_cast<btRigidBody*>(btRigidBody::upcast(&object))), origin(object.getWorldTransform().getOrigin()) {
    if (body == nullptr) return;
    inverse_mass = body->getInvMass();
    inverse_inertia = body->getInvInertiaTensorWorld();
  }
};

btScalar hardness(const btSoftBody& body, const btCollisionObject& object) {
  return object.isStaticOrKinematicObject() ? body.m_cfg.kKHR : body.m_cfg.kCHR;
}

// Bullet reads these members for multibody links only.
template <class RigidContact>
void clear_tangents(RigidContact& contact) {
  contact.t1.setZero();
  contact.t2.setZero();
}

/// Sets the response of a link, and of its whole multibody, to an impulse at `point`. `inverse_mass` is the soft body's
/// there; it is ignored for reduced bodies, whose contact matrix is that of the link alone.
template <class RigidContact>
void set_link_response(const btMultiBodyLinkCollider& link, const btVector3& point, const btMatrix3x3& inverse_mass,
                       bool is_reduced, RigidContact& contact) {
  contact.t1 = generateUnitOrthogonalVector(contact.m_cti.m_normal);
  contact.t2 = btCross(contact.m_cti.m_normal, contact.t1);
  findJacobian(&link, contact.jacobianData_normal, point, contact.m_cti.m_normal);
  findJacobian(&link, contact.jacobianData_t1, point, contact.t1);
  findJacobian(&link, contact.jacobianData_t2, point, contact.t2);
  const btVector3& n = contact.m_cti.m_normal;
  const btMatrix3x3 to_local(n.x(), n.y(), n.z(), contact.t1.x(), contact.t1.y(), contact.t1.z(), contact.t2.x(),
                             contact.t2.y(), contact.t2.z());
  const auto jacobian = [](const btMultiBodyJacobianData& data) { return &data.m_jacobians[0]; };
  const auto response = [](const btMultiBodyJacobianData& data) { return &data.m_deltaVelocitiesUnitImpulse[0]; };
  const btMatrix3x3 of_link = OuterProduct(jacobian(contact.jacobianData_normal), jacobian(contact.jacobianData_t1),
                                           jacobian(contact.jacobianData_t2), response(contact.jacobianData_normal),
                                           response(contact.jacobianData_t1), response(contact.jacobianData_t2),
                                           link.m_multiBody->getNumDofs() + 6);
  contact.m_c0 = to_local.transpose() * (is_reduced ? of_link : Add(inverse_mass, of_link).inverse()) * to_local;
}

/// Makes a contact of the point x of a soft body, which has moved by `motion`. Leaves out its node, its plane and the
/// part of the impulse that moves the node.
btSoftBody::RContact contact_of_point(const btSoftBody& body, const btVector3& x, const btVector3& motion,
                                      btScalar inverse_mass, const RigidSide& rigid, const RigidTouch& touch) {
  const btScalar time_step = body.m_sst.sdt;
  const btVector3 arm = x - rigid.origin;
  const btVector3 rigid_motion =
      rigid.body != nullptr ? rigid.body->getVelocityInLocalPoint(arm) * time_step : btVector3(0, 0, 0);
  const btVector3 relative = motion - rigid_motion;
  const btScalar along = relative.dot(touch.normal);
  const btVector3 across = relative - touch.normal * along;
  const btScalar friction = body.m_cfg.kDF * touch.object->getFriction();

  btSoftBody::RContact contact;
  contact.m_cti.m_colObj = touch.object;
  contact.m_cti.m_normal = touch.normal;
  contact.m_c0 = ImpulseMatrix(time_step, inverse_mass, rigid.inverse_mass, rigid.inverse_inertia, arm);
  contact.m_c1 = arm;
  contact.m_c3 = across.length2() < (along * friction) * (along * friction) ? btScalar(0) : 1 - friction;
  contact.m_c4 = hardness(body, *touch.object);
  clear_tangents(contact);
  return contact;
}

/// Least depth, relative to the margin. It gives a stopped node a motion away from the object, so that Bullet's solver
/// releases it.
constexpr btScalar kLeastDepth = btScalar(1e-3);
/// Hardness so small that the motion of a step makes no difference.
constexpr btScalar kFaceHardness = btScalar(1e-3);

/// Lets a node outside the margin come up to it. Bullet's solver stops the whole approach, even of a node that is far
/// from the object. A body under pressure, which gives its nodes large motions, would shrink away from the objects that
/// it touches. The solver adds m_c4 times the node's depth at that time, at most the body's margin: here a small
/// negative m_c4 times a depth so far below 0 that neither that bound nor the node's motion matters.
void allow_approach(btSoftBody::RContact& contact, btScalar distance) {
  contact.m_c4 = -kFaceHardness;
  contact.m_cti.m_offset = -distance / kFaceHardness - contact.m_cti.m_normal.dot(contact.m_node->m_x);
}

/// A point on a face whose nodes are pushed by their weights.
struct WeightedPoint {
  btVector3 x{0, 0, 0}, motion{0, 0, 0};
  /// At least half of the part of the node that gives way most. If the other nodes have no mass and this one has hardly
  /// any weight, it then moves by at most twice what the point should.
  btScalar inverse_mass = 0;

  WeightedPoint(const btSoftBody::Face& face, const btVector3& weights) {
    for (int i = 0; i < 3; ++i) {
      const btSoftBody::Node& node = *face.m_n[i];
      x += weights[i] * node.m_x;
      motion += weights[i] * (node.m_x - node.m_q);
      inverse_mass += weights[i] * weights[i] * node.m_im;
    }
    for (int i = 0; i < 3; ++i) inverse_mass = btMax(inverse_mass, weights[i] * face.m_n[i]->m_im / 2);
  }
};

}  // namespace

void write_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch) {
  const RigidSide rigid(*touch.object);
  if (!(node.m_im + rigid.inverse_mass > 0)) return;
  btSoftBody::RContact contact = contact_of_point(body, node.m_x, node.m_x - node.m_q, node.m_im, rigid, touch);
  contact.m_cti.m_offset = -touch.normal.dot(touch.object_point_t1) - touch.margin;
  contact.m_node = &node;
  contact.m_c2 = node.m_im * body.m_sst.sdt;
  const btScalar depth_at_start = depth(touch, node.m_q, touch.object_point_t0);
  if (depth_at_start > 0) allow_approach(contact, depth_at_start);
  body.m_rcontacts.push_back(contact);
  if (rigid.body != nullptr) rigid.body->activate();
}

void write_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch) {
  const RigidSide rigid(*touch.object);
  const WeightedPoint point(face, weights);
  if (!(point.inverse_mass + rigid.inverse_mass > 0)) return;
  const btSoftBody::RContact whole = contact_of_point(body, point.x, point.motion, point.inverse_mass, rigid, touch);
  // Bullet's solver stops the approach, and adds m_c4 times the depth of the nodes at that time, so that it attracts
  // nodes that are not deep. Here it adds the hardness times the depth at the start of the step, independent of the
  // nodes' positions.
  const btScalar depth_at_start = depth(touch, point.x - point.motion, touch.object_point_t0);
  const btScalar depth_to_answer = btMin(depth_at_start, -kLeastDepth * touch.margin) * whole.m_c4 / kFaceHardness;
  for (int i = 0; i < 3; ++i) {
    btSoftBody::Node& node = *face.m_n[i];
    if (!(weights[i] > kLeastWeight) || !(node.m_im + rigid.inverse_mass > 0)) continue;
    btSoftBody::RContact contact = whole;
    contact.m_cti.m_offset = depth_to_answer - touch.normal.dot(node.m_x);
    contact.m_node = &node;
    contact.m_c0 = whole.m_c0 * weights[i];
    contact.m_c2 = node.m_im * body.m_sst.sdt;
    contact.m_c4 = kFaceHardness;
    body.m_rcontacts.push_back(contact);
  }
  if (rigid.body != nullptr) rigid.body->activate();
}

void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch) {
  const RigidSide rigid(*touch.object);
  if (!(node.m_im + rigid.inverse_mass > 0)) return;
  const btVector3 arm = node.m_x - rigid.origin;

  btSoftBody::DeformableNodeRigidContact contact;
  contact.m_cti.m_colObj = touch.object;
  contact.m_cti.m_normal = touch.normal;
  contact.m_cti.m_offset = depth(touch, node.m_x, touch.object_point_t0);
  contact.m_node = &node;
  contact.m_c0 = body.m_reducedModel
                     ? MassMatrix(rigid.inverse_mass, rigid.inverse_inertia, arm)
                     : ImpulseMatrix(1, node.m_effectiveMass_inv, rigid.inverse_mass, rigid.inverse_inertia, arm);
  contact.m_c1 = arm;
  contact.m_c2 = node.m_im;
  contact.m_c3 = body.m_cfg.kDF * touch.object->getFriction();
  contact.m_c4 = hardness(body, *touch.object);
  contact.m_c5 = node.m_effectiveMass_inv;
  clear_tangents(contact);
  if (const auto* link = btMultiBodyLinkCollider::upcast(touch.object)) {
    set_link_response(*link, node.m_x, node.m_effectiveMass_inv, body.m_reducedModel, contact);
  }
  body.m_nodeRigidContacts.push_back(contact);
}

void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights,
                                    const RigidTouch& touch) {
  const RigidSide rigid(*touch.object);
  // Bullet's weights of the impulse at the face's nodes.
  const btVector3 impulse_weights = 2 / (1 + weights.length2()) * weights;
  btScalar inverse_mass = 0;
  btVector3 point(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    inverse_mass += weights[i] * impulse_weights[i] * face.m_n[i]->m_im;
    point += weights[i] * face.m_n[i]->m_x;
  }
  if (!(inverse_mass + rigid.inverse_mass > 0)) return;
  const btVector3 arm = point - rigid.origin;

  btSoftBody::DeformableFaceRigidContact contact;
  contact.m_cti.m_colObj = touch.object;
  contact.m_cti.m_normal = touch.normal;
  contact.m_cti.m_offset = depth(touch, point, touch.object_point_t0);
  contact.m_contactPoint = point;
  contact.m_bary = weights;
  contact.m_weights = impulse_weights;
  contact.m_face = &face;
  contact.m_c0 = ImpulseMatrix(1, inverse_mass, rigid.inverse_mass, rigid.inverse_inertia, arm);
  contact.m_c1 = arm;
  contact.m_c2 = inverse_mass;
  contact.m_c3 = body.m_cfg.kDF * touch.object->getFriction();
  contact.m_c4 = hardness(body, *touch.object);
  contact.m_c5 = Diagonal(inverse_mass);
  clear_tangents(contact);
  if (const auto* link = btMultiBodyLinkCollider::upcast(touch.object)) {
    set_link_response(*link, point, Diagonal(inverse_mass), /*is_reduced=*/false, contact);
  }
  body.m_faceRigidContacts.push_back(contact);
  // Clears Bullet's cached contact point of the face, as Bullet does when it detects contacts.
  face.m_pcontact[3] = 0;
}

}  // namespace softcd::bullet
