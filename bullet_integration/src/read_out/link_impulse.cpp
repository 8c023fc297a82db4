#include "read_out/link_impulse.hpp"

#include <numeric>

#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

namespace softcd::bullet {

LinkImpulse::LinkImpulse(const btSoftBody::RContact& contact) : normal_(contact.m_cti.m_normal) {
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

btVector3 LinkImpulse::since_begin() const {
  btScalar product = 0;
  for (std::size_t i = 0; i < before_.size(); ++i) {
    product += (body_->getVelocityVector()[i] - before_[i]) * change_of_unit_impulse_[i];
  }
  return normal_ * (product / squared_length_);
}

}  // namespace softcd::bullet
