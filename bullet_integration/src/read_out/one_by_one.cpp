#include "read_out/one_by_one.hpp"

#include <utility>

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

namespace softcd::bullet {

bool is_moved_by_impulses(const btCollisionObject& object) {
  if (const btRigidBody* rigid = btRigidBody::upcast(&object)) return rigid->getInvMass() > 0;
  const btMultiBodyLinkCollider* collider = btMultiBodyLinkCollider::upcast(&object);
  if (collider == nullptr) return false;
  const btMultiBody& body = *collider->m_multiBody;
  for (int link = collider->m_link; link >= 0; link = body.getLink(link).m_parent) {
    if (body.getLink(link).m_dofCount > 0) return true;
  }
  return !body.hasFixedBase();
}

namespace {

/// Solves the body's only contact with a rigid object. Bullet's classic solver pushes a multibody along the contact's
/// normal only, by half the length of the node's impulse.
ContactImpulses::Impulse solve_alone(btSoftBody& body, btSoftBody::RContact& contact, btScalar progress) {
  btSoftBody::Node& node = *contact.m_node;
  const bool has_mass = node.m_im > 0;
  const btRigidBody* rigid = btRigidBody::upcast(contact.m_cti.m_colObj);
  const bool is_moved = is_moved_by_impulses(*contact.m_cti.m_colObj);
  const btVector3 x = node.m_x;
  const btVector3 velocity = rigid != nullptr ? rigid->getLinearVelocity() : btVector3(0, 0, 0);
  // A node without mass moves here by its impulse, to show it, and then back.
  const btScalar motion = std::exchange(contact.m_c2, has_mass ? contact.m_c2 : btScalar(1));
  btSoftBody::PSolve_RContacts(&body, 1, progress);
  const btVector3 on_node = (node.m_x - x) / contact.m_c2;
  contact.m_c2 = motion;
  if (!has_mass) node.m_x = x;
  ContactImpulses::Impulse impulse;
  if (has_mass) impulse.on_owner = on_node;
  if (!is_moved) {
    impulse.on_other = -impulse.on_owner;
  } else if (rigid != nullptr) {
    impulse.on_other = (rigid->getLinearVelocity() - velocity) / rigid->getInvMass();
  } else {
    impulse.on_other = contact.m_cti.m_normal * (on_node.length() / -2);
  }
  return impulse;
}

}  // namespace

void solve_rigid_contacts(btSoftBody& body, btScalar progress, std::vector<ContactImpulses::Impulse>& impulses) {
  for (int i = 0; i < body.m_rcontacts.size(); ++i) {
    with_single_entry(body.m_rcontacts, i, [&](btSoftBody::RContact& contact) {
      impulses[static_cast<std::size_t>(i)] += solve_alone(body, contact, progress);
    });
  }
}

}  // namespace softcd::bullet
