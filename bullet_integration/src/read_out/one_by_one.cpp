#include "read_out/one_by_one.hpp"

#include <numeric>
#include <vector>

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

namespace softcd::bullet {
namespace {

/// Measures the impulse that Bullet's classic solver gives to the link of a contact. It pushes a multibody along the
/// contact's normal only, by half the length of the node's impulse.
class LinkImpulse {
 public:
  /// Call it right before the contact is solved alone.
  explicit LinkImpulse(const btSoftBody::RContact& contact) : normal_(contact.m_cti.m_normal) {
    const auto* const link = btMultiBodyLinkCollider::upcast(contact.m_cti.m_colObj);
    if (link == nullptr) return;
    body_ = link->m_multiBody;
    constexpr std::size_t kBaseDofs = 6;
    const std::size_t count = static_cast<std::size_t>(body_->getNumDofs()) + kBaseDofs;
    before_.assign(body_->getVelocityVector(), body_->getVelocityVector() + count);
    std::vector<btScalar> jacobian(count);
    change_of_unit_impulse_.resize(count);
    btAlignedObjectArray<btScalar> scalars;
    btAlignedObjectArray<btVector3> vectors;
    btAlignedObjectArray<btMatrix3x3> matrices;
    body_->fillContactJacobianMultiDof(link->m_link, contact.m_node->m_x, normal_, jacobian.data(), scalars, vectors,
                                       matrices);
    body_->calcAccelerationDeltasMultiDof(jacobian.data(), change_of_unit_impulse_.data(), scalars, vectors);
    const std::vector<btScalar>& change = change_of_unit_impulse_;
    squared_length_ = std::inner_product(change.begin(), change.end(), change.begin(), btScalar(0));
  }
  /// Returns whether the contact's object is a link that an impulse along the normal moves.
  bool is_moved() const { return squared_length_ > 0; }
  /// Returns the impulse since the constructor, kg m/s.
  btVector3 since_begin() const {
    btScalar product = 0;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      product += (body_->getVelocityVector()[i] - before_[i]) * change_of_unit_impulse_[i];
    }
    return normal_ * (product / squared_length_);
  }

 private:
  const btVector3 normal_;
  btMultiBody* body_ = nullptr;  ///< null if the object is no link
  std::vector<btScalar> before_;
  std::vector<btScalar> change_of_unit_impulse_;  ///< of the multibody's velocities, along the normal
  btScalar squared_length_ = 0;                   ///< of that change
};

}  // namespace

ContactImpulses::Impulse solve_rigid_contact_alone(btSoftBody& body, const btSoftBody::RContact& contact,
                                                   btScalar progress) {
  const btSoftBody::Node& node = *contact.m_node;
  const btRigidBody* rigid = btRigidBody::upcast(contact.m_cti.m_colObj);
  const bool is_moved = rigid != nullptr && rigid->getInvMass() > 0;
  const btVector3 x = node.m_x;
  const btVector3 velocity = is_moved ? rigid->getLinearVelocity() : btVector3(0, 0, 0);
  const LinkImpulse on_link(contact);
  btSoftBody::PSolve_RContacts(&body, 1, progress);
  ContactImpulses::Impulse impulse;
  if (node.m_im > 0) impulse.on_owner = (node.m_x - x) * (body.m_sst.isdt / node.m_im);
  if (is_moved) {
    impulse.on_other = (rigid->getLinearVelocity() - velocity) / rigid->getInvMass();
  } else {
    impulse.on_other = on_link.is_moved() ? on_link.since_begin() : -impulse.on_owner;
  }
  return impulse;
}

}  // namespace softcd::bullet
