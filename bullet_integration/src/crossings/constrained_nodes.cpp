#include "crossings/constrained_nodes.hpp"

#include "native/arrays.hpp"

namespace softcd::bullet {
namespace {

/// Least part of a normal that counts as a new direction. A smaller part is rounding, or comes from the curvature of
/// the rigid object.
constexpr btScalar kNewDirection = btScalar(0.1);
/// A remaining part of a change below this share is rounding: the change lies in known directions.
constexpr btScalar kRounding = btScalar(1e-3);

}  // namespace

btVector3 NodeConstraint::free_part(const btVector3& change) const {
  if (count_ == 3) return {0, 0, 0};
  btVector3 rest = change;
  for (int i = 0; i < count_; ++i) rest -= directions_[i] * directions_[i].dot(rest);
  return rest.length2() > kRounding * kRounding * change.length2() ? rest : btVector3(0, 0, 0);
}

void NodeConstraint::add_direction(const btVector3& direction) {
  const btVector3 rest = free_part(direction);
  if (rest.length() > kNewDirection) directions_[count_++] = rest.normalized();
}

void NodeConstraint::anchor() {
  is_anchored_ = true;
  count_ = 0;
  for (int axis = 0; axis < 3; ++axis) {
    btVector3 direction(0, 0, 0);
    direction[axis] = 1;
    directions_[count_++] = direction;
  }
}

void ConstrainedNodes::add_direction(const btSoftBody::Node& node, const btVector3& direction) {
  if (node.m_constrained != 0) constraints_[&node].add_direction(direction);
}

void ConstrainedNodes::add(const btSoftBody& body) {
  for (const btSoftBody::DeformableNodeRigidContact& contact : span_of(body.m_nodeRigidContacts)) {
    add_direction(*contact.m_node, contact.m_cti.m_normal);
  }
  for (const btSoftBody::DeformableFaceRigidContact& contact : span_of(body.m_faceRigidContacts)) {
    for (const btSoftBody::Node* node : contact.m_face->m_n) add_direction(*node, contact.m_cti.m_normal);
  }
  for (const btSoftBody::DeformableNodeRigidAnchor& anchor : span_of(body.m_deformableAnchors)) {
    constraints_[anchor.m_node].anchor();
  }
}

const NodeConstraint* ConstrainedNodes::find(const btSoftBody::Node& node) const {
  const auto found = constraints_.find(&node);
  return found == constraints_.end() ? nullptr : &found->second;
}

}  // namespace softcd::bullet
