#include "worlds/sweep_box.hpp"

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"

namespace softcd::bullet {

void sweep_box(btSoftBody& body, btBroadphaseInterface& broadphase, btDispatcher* dispatcher) {
  // A body that sleeps was not predicted: its m_q means nothing.
  if (!body.isActive() || body.getBroadphaseHandle() == nullptr || body.m_nodes.size() == 0) return;
  btVector3 low = body.m_nodes[0].m_q;
  btVector3 high = low;
  for (int i = 1; i < body.m_nodes.size(); ++i) {
    low.setMin(body.m_nodes[i].m_q);
    high.setMax(body.m_nodes[i].m_q);
  }
  const btScalar margin = body.getCollisionShape()->getMargin();
  low -= btVector3(margin, margin, margin);
  high += btVector3(margin, margin, margin);
  low.setMin(body.m_bounds[0]);
  high.setMax(body.m_bounds[1]);
  broadphase.setAabb(body.getBroadphaseHandle(), low, high, dispatcher);
}

}  // namespace softcd::bullet
