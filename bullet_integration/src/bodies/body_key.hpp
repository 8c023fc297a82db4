#pragma once

#include <cstddef>
#include <functional>
#include <tuple>

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

namespace softcd::bullet {

/// Identifies a body by its address and the number of its broad phase's proxy, which is new whenever a body is added to
/// a world. So a later body at the same address is another one. Only btAxisSweep3 uses numbers again. A body in no
/// world is identified by its user index.
struct BodyKey {
  const btCollisionObject* object = nullptr;
  int number = 0;

  explicit BodyKey(const btCollisionObject& of)
      : object(&of),
        number(of.getBroadphaseHandle() != nullptr ? of.getBroadphaseHandle()->m_uniqueId : of.getUserIndex()) {}
  explicit BodyKey(const btBroadphaseProxy& of)
      : object(static_cast<const btCollisionObject*>(of.m_clientObject)), number(of.m_uniqueId) {}
  friend bool operator<(const BodyKey& a, const BodyKey& b) {
    return std::tie(a.object, a.number) < std::tie(b.object, b.number);
  }
  friend bool operator==(const BodyKey& a, const BodyKey& b) { return a.object == b.object && a.number == b.number; }
};

struct BodyKeyHash {
  std::size_t operator()(const BodyKey& key) const { return std::hash<const void*>()(key.object); }
};

}  // namespace softcd::bullet
