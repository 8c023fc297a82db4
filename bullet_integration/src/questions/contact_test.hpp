#pragma once

#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "questions/soft_body_scene.hpp"

namespace softcd::bullet {

/// Reports the contacts of `object` with `others` to the callback: see WorldProbe. `others` may be only the object
/// itself. One object of each pair is a soft body. Rigid objects are in the scene only during the call.
void test_contacts(SoftBodyScene& bodies, btCollisionObject& object, const std::vector<btCollisionObject*>& others,
                   btCollisionWorld::ContactResultCallback& callback);

}  // namespace softcd::bullet
