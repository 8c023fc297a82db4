#pragma once

#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "questions/soft_body_scene.hpp"

namespace softcd::bullet {

/// Tells the callback what of the object touches the others, of which it may be the only one itself: see WorldProbe. In
/// each pair there is a soft body; rigid objects are in the scene for the length of the call.
void test_contacts(SoftBodyScene& bodies, btCollisionObject& object, const std::vector<btCollisionObject*>& others,
                   btCollisionWorld::ContactResultCallback& callback);

}  // namespace softcd::bullet
