#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// A soft body's triangles as node indices. Nodes without a face (of a rope, say) collide as points: each gets a
/// triangle {n, n, n} behind the faces'.
struct BodyMesh {
  std::vector<Triangle> triangles;
  std::uint32_t face_count = 0;  ///< triangles from here on stand for single nodes
  std::uint32_t node_count = 0;
};

/// Whether the body's faces still join the nodes that `mesh` says. Bullet leaves no reliable trace of a change:
/// refine() and randomizeConstraints() reorder faces in place, so all of them are compared.
bool is_up_to_date(const BodyMesh& mesh, const btSoftBody& body);

BodyMesh read_mesh(const btSoftBody& body);

/// Margin, self collision and whether the body can be moved by contacts, as they are now.
BodySettings read_settings(const btSoftBody& body, SelfCollision self_collision);

/// Where the nodes are now, or were at the start of the step. Views of the body's own memory.
Positions positions_now(const btSoftBody& body);
Positions positions_at_start(const btSoftBody& body);

}  // namespace softcd::bullet
