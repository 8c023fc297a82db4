#include "body_ids.hpp"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <fmt/format.h>

#include "softcd/error.hpp"

namespace softcd::bullet::pybullet {

ObjectIds ids_of(const btCollisionObject* object) {
  if (object == nullptr) return {};
  const auto* const link = btMultiBodyLinkCollider::upcast(object);
  if (link != nullptr && link->m_multiBody != nullptr) return {link->m_multiBody->getUserIndex2(), link->m_link};
  return {object->getUserIndex2(), -1};
}

std::vector<btSoftBody*> soft_bodies_of(const btDynamicsWorld& world) {
  std::vector<btSoftBody*> bodies;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    if (btSoftBody* const body = btSoftBody::upcast(objects[i])) bodies.push_back(body);
  }
  return bodies;
}

btSoftBody& soft_body_with(const btDynamicsWorld& world, int id) {
  for (btSoftBody* const body : soft_bodies_of(world)) {
    if (ids_of(body).body == id) return *body;
  }
  throw InvalidInput(fmt::format("body: {} is no soft body of this client; expected an id from loadSoftBody.", id));
}

}  // namespace softcd::bullet::pybullet
