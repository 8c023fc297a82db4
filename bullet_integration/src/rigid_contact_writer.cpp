#include "rigid_contact_writer.hpp"

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletSoftBody/btSoftBodyInternals.h"

namespace softcd::bullet {
namespace {

/// What the formulas need of a rigid object; one that is no btRigidBody does not move.
struct RigidPart {
  btRigidBody* body;
  btScalar inverse_mass = 0;
  btMatrix3x3 inverse_inertia{0, 0, 0, 0, 0, 0, 0, 0, 0};
  btVector3 origin;

  explicit RigidPart(const btCollisionObject& object)
      : body(const_cast<btRigidBody*>(btRigidBody::upcast(&object))), origin(object.getWorldTransform().getOrigin()) {
    if (body == nullptr) return;
    inverse_mass = body->getInvMass();
    inverse_inertia = body->getInvInertiaTensorWorld();
  }
};

btScalar hardness(const btSoftBody& body, const btCollisionObject& object) {
  return object.isStaticOrKinematicObject() ? body.m_cfg.kKHR : body.m_cfg.kCHR;
}

// Bullet reads them for multibody links only.
template <class RigidContact>
void clear_tangents(RigidContact& contact) {
  contact.t1.setZero();
  contact.t2.setZero();
}

}  // namespace

void write_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch) {
  const RigidPart rigid(*touch.object);
  if (!(node.m_im + rigid.inverse_mass > 0)) return;
  const btScalar time_step = body.m_sst.sdt;
  const btVector3 arm = node.m_x - rigid.origin;
  const btVector3 rigid_motion =
      rigid.body != nullptr ? rigid.body->getVelocityInLocalPoint(arm) * time_step : btVector3(0, 0, 0);
  const btVector3 motion = node.m_x - node.m_q - rigid_motion;
  const btScalar along = motion.dot(touch.normal);
  const btVector3 across = motion - touch.normal * along;
  const btScalar friction = body.m_cfg.kDF * touch.object->getFriction();

  btSoftBody::RContact contact;
  contact.m_cti.m_colObj = touch.object;
  contact.m_cti.m_normal = touch.normal;
  contact.m_cti.m_offset = -touch.normal.dot(touch.object_point_t1) - touch.margin;
  contact.m_node = &node;
  contact.m_c0 = ImpulseMatrix(time_step, node.m_im, rigid.inverse_mass, rigid.inverse_inertia, arm);
  contact.m_c1 = arm;
  contact.m_c2 = node.m_im * time_step;
  contact.m_c3 = across.length2() < (along * friction) * (along * friction) ? btScalar(0) : 1 - friction;
  contact.m_c4 = hardness(body, *touch.object);
  clear_tangents(contact);
  body.m_rcontacts.push_back(contact);
  if (rigid.body != nullptr) rigid.body->activate();
}

void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch) {
  const RigidPart rigid(*touch.object);
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
  body.m_nodeRigidContacts.push_back(contact);
}

void write_deformable_rigid_contact(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights,
                                    const RigidTouch& touch) {
  const RigidPart rigid(*touch.object);
  // Bullet's weights: of the impulse at the face's nodes.
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
  body.m_faceRigidContacts.push_back(contact);
  // Bullet's cached contact point of the face, which it forgets whenever it looks for contacts.
  face.m_pcontact[3] = 0;
}

}  // namespace softcd::bullet
