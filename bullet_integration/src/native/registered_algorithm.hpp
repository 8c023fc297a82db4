#pragma once

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"

namespace softcd::bullet {

/// Returns the dispatcher's entry for pairs of these types of shapes, which makes their algorithms.
inline btCollisionAlgorithmCreateFunc*& registered_algorithm(btCollisionDispatcher& dispatcher, int type0, int type1) {
  // Bullet has a public function that writes the table, but only derived classes can read it.
  struct Table : btCollisionDispatcher {
    static auto& of(btCollisionDispatcher& any) { return any.*&Table::m_doubleDispatchContactPoints; }
  };
  return Table::of(dispatcher)[type0][type1];
}

/// While it lives, `dispatcher` makes the algorithms for pairs of these types of shapes with `create`. Its destructor
/// restores the former entry, unless the entry has changed again.
class RegisteredAlgorithm {
 public:
  RegisteredAlgorithm(btCollisionDispatcher& dispatcher, int type0, int type1, btCollisionAlgorithmCreateFunc& create)
      : entry_(registered_algorithm(dispatcher, type0, type1)), create_(&create), original_(entry_) {
    entry_ = create_;
  }
  ~RegisteredAlgorithm() {
    if (entry_ == create_) entry_ = original_;
  }
  RegisteredAlgorithm(const RegisteredAlgorithm&) = delete;
  RegisteredAlgorithm& operator=(const RegisteredAlgorithm&) = delete;

 private:
  btCollisionAlgorithmCreateFunc*& entry_;
  btCollisionAlgorithmCreateFunc* create_;
  btCollisionAlgorithmCreateFunc* original_;
};

}  // namespace softcd::bullet
