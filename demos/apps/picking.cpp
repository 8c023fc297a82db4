// Simulates a mouse: a ray from the eye picks a face of a soft body, and the node nearest to the hit is pulled along.
// The rays are Bullet's own; in softcd's world they meet soft bodies at their present positions.

#include <softcd/bullet/soft_worlds.hpp>

#include <cstdio>
#include <memory>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"

/// Finds the nearest face. ClosestRayResultCallback keeps the nearest point only.
struct PickedFace : btCollisionWorld::ClosestRayResultCallback {
  using ClosestRayResultCallback::ClosestRayResultCallback;
  int face = -1;

  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool is_in_world_space) override {
    face = result.m_localShapeInfo != nullptr ? result.m_localShapeInfo->m_triangleIndex : -1;
    return ClosestRayResultCallback::addSingleResult(result, is_in_world_space);
  }

  btSoftBody::Node* nearest_node() const {
    btSoftBody* body = btSoftBody::upcast(const_cast<btCollisionObject*>(m_collisionObject));
    if (body == nullptr) return nullptr;
    btSoftBody::Node* nearest = nullptr;
    for (btSoftBody::Node* node : body->m_faces[face].m_n) {
      const bool is_nearer =
          nearest == nullptr || node->m_x.distance2(m_hitPointWorld) < nearest->m_x.distance2(m_hitPointWorld);
      if (is_nearer) nearest = node;
    }
    return nearest;
  }
};

int main() {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

  const std::unique_ptr<btSoftBody> cloth(
      btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 0, -1), btVector3(1, 0, -1),
                                     btVector3(-1, 0, 1), btVector3(1, 0, 1), 20, 20, 1 + 2 + 4 + 8, true));
  cloth->getCollisionShape()->setMargin(0.02F);
  world.addSoftBody(cloth.get());

  const btVector3 eye(0.5F, 3, 4);
  const btVector3 beyond = eye + 2 * (btVector3(0.1F, 0, 0.2F) - eye);
  for (int round = 0; round < 3; ++round) {
    PickedFace picked(eye, beyond);
    world.rayTest(eye, beyond, picked);
    btSoftBody::Node* const node = picked.nearest_node();
    if (node == nullptr) break;
    std::printf("picked face %d at height %.3f\n", picked.face, static_cast<double>(picked.m_hitPointWorld.y()));
    for (int step = 0; step < 15; ++step) {
      node->m_v = btVector3(0, 2, 0);
      world.stepSimulation(btScalar(1) / 60, 0);
    }
    std::printf("pulled its node %d to height %.3f\n", static_cast<int>(node - &cloth->m_nodes[0]),
                static_cast<double>(node->m_x.y()));
  }
  world.removeSoftBody(cloth.get());
}
