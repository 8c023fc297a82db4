#pragma once

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

/// Appends a vertex-triangle contact to the vertex's body with Bullet's own formulas (CollideVF_SS), so that
/// Bullet's solver treats it as one of its own. Nothing is appended when all nodes of both sides are fixed.
void write_contact(btSoftBody& node_body, btSoftBody& face_body, const Contact& contact, Detection detection);

}  // namespace softcd::bullet
