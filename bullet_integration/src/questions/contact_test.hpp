#pragma once

#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "bodies/world_mirror.hpp"

namespace softcd::bullet {

/// Reports the contacts of `object` with `others` to the callback: see WorldProbe. `others` may be only the object
/// itself. One object of each pair is a soft body. `bodies` is a probe's. Rigid objects are in its scene only during
/// the call.
void test_contacts(WorldMirror& bodies, btCollisionObject& object, const std::vector<btCollisionObject*>& others,
                   btCollisionWorld::ContactResultCallback& callback);

}  // namespace softcd::bullet
