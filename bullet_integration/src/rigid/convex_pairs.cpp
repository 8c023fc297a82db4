#include "rigid/convex_pairs.hpp"

namespace softcd::bullet {
namespace {

using Flags = btSoftBody::fCollision;

bool is_looked_at(const btSoftBody& soft, const btCollisionObject& object) {
  const int kind = soft.m_cfg.collisions & Flags::RVSmask;
  const int type = object.getInternalType();
  return (kind == Flags::SDF_RS || kind == Flags::SDF_RD) && object.hasContactResponse() &&
         (type == btCollisionObject::CO_RIGID_BODY || type == btCollisionObject::CO_FEATHERSTONE_LINK ||
          type == btCollisionObject::CO_COLLISION_OBJECT);
}

// A compound's children come with a parent: it was told of as a whole.
bool tell_of(ConvexPairs& pairs, btSoftBody& soft, const btCollisionObjectWrapper& rigid) {
  const btCollisionObject* object = rigid.getCollisionObject();
  if (rigid.m_parent == nullptr && is_looked_at(soft, *object)) pairs.add({&soft, object});
  return false;
}

}  // namespace

CollectingConvexPairs::CollectingConvexPairs(btCollisionDispatcher& dispatcher,
                                             const std::shared_ptr<ConvexPairs>& pairs)
    : CollectingPairs(pairs, tell_of) {
  for (int type = BOX_SHAPE_PROXYTYPE; type < CONCAVE_SHAPES_START_HERE; ++type) stand_before(dispatcher, type);
  stand_before(dispatcher, COMPOUND_SHAPE_PROXYTYPE);
}

}  // namespace softcd::bullet
