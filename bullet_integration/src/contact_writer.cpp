#include "contact_writer.hpp"

namespace softcd::bullet {
namespace {

// Bullet's margin for a contact of `node`: both bodies' margins, plus twice the node's motion in a discrete
// detection. Not so within a body, where it is motion relative to the face that counts, and Bullet has no rule.
btScalar contact_margin(const btSoftBody& node_body, const btSoftBody& face_body, const btSoftBody::Node& node,
                        Detection detection) {
  const btScalar margins = node_body.getCollisionShape()->getMargin() + face_body.getCollisionShape()->getMargin();
  if (detection == Detection::ccd || &node_body == &face_body) return margins;
  return margins + (node.m_x - node.m_q).length() * 2;
}

// As the solver sees the face at the contact: immovable as soon as one of its nodes is.
btScalar inverse_mass_of(const btSoftBody::Face& face, const btVector3& weights) {
  btScalar inverse_mass = 0;
  for (int i = 0; i < 3; ++i) {
    if (face.m_n[i]->m_im <= 0) return 0;
    inverse_mass += face.m_n[i]->m_im * weights[i];
  }
  return inverse_mass;
}

}  // namespace

void write_contact(btSoftBody& node_body, btSoftBody& face_body, const Contact& contact, Detection detection) {
  btSoftBody::Node& node = node_body.m_nodes[static_cast<int>(contact.feature_a)];
  btSoftBody::Face& face = face_body.m_faces[static_cast<int>(contact.feature_b)];
  const btScalar margin = contact_margin(node_body, face_body, node, detection);
  if (detection == Detection::dcd && btScalar(contact.distance) > margin) return;

  const btVector3 weights(btScalar(contact.weights[1]), btScalar(contact.weights[2]), btScalar(contact.weights[3]));
  const btScalar node_inverse_mass = node.m_im;
  const btScalar face_inverse_mass = inverse_mass_of(face, weights);
  const btScalar sum = node_inverse_mass + face_inverse_mass;
  if (!(sum > 0)) return;

  btSoftBody::SContact soft_contact;
  soft_contact.m_node = &node;
  soft_contact.m_face = &face;
  soft_contact.m_weights = weights;
  soft_contact.m_normal = btVector3(btScalar(contact.normal.x), btScalar(contact.normal.y), btScalar(contact.normal.z));
  soft_contact.m_margin = margin;
  soft_contact.m_friction = btMax(node_body.m_cfg.kDF, face_body.m_cfg.kDF);
  soft_contact.m_cfm[0] = node_inverse_mass / sum * node_body.m_cfg.kSHR;
  soft_contact.m_cfm[1] = face_inverse_mass / sum * face_body.m_cfg.kSHR;
  node_body.m_scontacts.push_back(soft_contact);
}

}  // namespace softcd::bullet
