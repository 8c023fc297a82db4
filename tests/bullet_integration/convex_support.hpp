#pragma once

#include <array>
#include <memory>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "any_simulation.hpp"

namespace softcd::test {

inline bullet::Settings with_faces_and_edges(Detection detection = Detection::dcd) {
  bullet::Settings settings = test_settings(detection);
  settings.convex_shapes = bullet::ConvexShapes::faces_and_edges;
  return settings;
}

/// One face, two metres large, in the plane y = 0 around the origin. Held where it has no mass.
inline std::unique_ptr<btSoftBody> make_triangle(btSoftBodyWorldInfo& world_info, btScalar mass) {
  const std::array<btVector3, 3> corners = {btVector3(-1, 0, -1), btVector3(1, 0, -1), btVector3(0, 0, 1)};
  auto triangle = std::make_unique<btSoftBody>(&world_info, 3, corners.data(), nullptr);
  triangle->appendFace(0, 1, 2);
  for (int i = 0; i < 3; ++i) {
    triangle->appendLink(i, (i + 1) % 3);
    triangle->setMass(i, mass / 3);
  }
  triangle->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  triangle->m_cfg.piterations = 4;
  triangle->getCollisionShape()->setMargin(btScalar(0.02));
  return triangle;
}

/// A tenth of a metre wide.
inline std::unique_ptr<btBoxShape> make_small_box() {
  return std::make_unique<btBoxShape>(btVector3(btScalar(0.05), btScalar(0.05), btScalar(0.05)));
}

}  // namespace softcd::test
