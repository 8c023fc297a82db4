#pragma once

#include "BulletSoftBody/btSoftBody.h"

class btBroadphaseInterface;

namespace softcd::bullet {

/// Makes the body's box in the broad phase one around the whole step, from m_q to m_x or back. Bullet's own is around
/// one end: what moves further than its size is not paired with what it passes.
void sweep_box(btSoftBody& body, btBroadphaseInterface& broadphase, btDispatcher* dispatcher);

}  // namespace softcd::bullet
