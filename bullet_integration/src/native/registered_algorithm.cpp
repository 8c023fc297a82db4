#include "native/registered_algorithm.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"

namespace softcd::bullet {
namespace {

// Bullet has a public function that writes the table, but only derived classes can read it.
struct Table : btCollisionDispatcher {
  static btCollisionAlgorithmCreateFunc*& entry(btCollisionDispatcher& dispatcher, int type0, int type1) {
    return (dispatcher.*&Table::m_doubleDispatchContactPoints)[type0][type1];
  }
};

}  // namespace

RegisteredAlgorithm::RegisteredAlgorithm(btCollisionDispatcher& dispatcher, int type0, int type1,
                                         btCollisionAlgorithmCreateFunc& create)
    : entry_(Table::entry(dispatcher, type0, type1)), create_(&create), original_(entry_) {
  entry_ = create_;
}

RegisteredAlgorithm::~RegisteredAlgorithm() {
  if (entry_ == create_) entry_ = original_;
}

}  // namespace softcd::bullet
