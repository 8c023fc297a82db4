#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"

class btMultiBody;

namespace softcd::bullet {

/// Measures the impulse that Bullet's classic solver gives to the link of a contact. It pushes a multibody along the
/// contact's normal only, by half the length of the node's impulse.
class LinkImpulse {
 public:
  /// Call it right before the contact is solved alone.
  explicit LinkImpulse(const btSoftBody::RContact& contact);
  /// Returns whether the contact's object is a link that an impulse along the normal moves.
  bool is_moved() const { return squared_length_ > 0; }
  /// Returns the impulse since the constructor, kg m/s.
  btVector3 since_begin() const;

 private:
  const btVector3 normal_;
  btMultiBody* body_ = nullptr;  ///< null if the object is no link
  std::vector<btScalar> before_;
  std::vector<btScalar> change_of_unit_impulse_;  ///< of the multibody's velocities, along the normal
  btScalar squared_length_ = 0;                   ///< of that change
};

}  // namespace softcd::bullet
