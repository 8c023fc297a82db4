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

}  // namespace softcd::bullet
