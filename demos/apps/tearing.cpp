// A ball falls onto a cloth that tears where it is stretched. While the world runs, links are cut in two, with new
// nodes and faces. softcd notices the changes of the cloth, and nothing passes through it except where it is torn.

#include <softcd/bullet/soft_worlds.hpp>

#include <cstdio>
#include <memory>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "tear.hpp"

int main() {
  softcd::bullet::Settings settings;
  settings.detection = softcd::Detection::ccd;
  settings.edge_contacts = softcd::bullet::EdgeContacts::respond;

  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  softcd::bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr, settings);

  const int corners = 1 + 2 + 4 + 8;
  const std::unique_ptr<btSoftBody> cloth(
      btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 0, -1), btVector3(1, 0, -1),
                                     btVector3(-1, 0, 1), btVector3(1, 0, 1), 21, 21, corners, /*gendiags=*/true));
  cloth->setTotalMass(1);
  const std::unique_ptr<btSoftBody> ball(btSoftBodyHelpers::CreateEllipsoid(world.getWorldInfo(), btVector3(0, 0.5F, 0),
                                                                            btVector3(0.3F, 0.3F, 0.3F), 200));
  ball->setTotalMass(4);
  ball->setPose(/*bvolume=*/false, /*bframe=*/true);
  ball->m_cfg.kMT = 0.2F;  // keeps its shape
  ball->setVelocity(btVector3(0, -4, 0));
  for (btSoftBody* body : {cloth.get(), ball.get()}) {
    body->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
    body->m_cfg.piterations = 4;
    body->getCollisionShape()->setMargin(0.02F);
    world.addSoftBody(body);
  }

  int cuts = 0;
  unsigned long long crossings = 0;
  for (int step = 0; step < 60; ++step) {
    for (const Ends& link : overstretched_links(*cloth, /*stretch=*/1.5F, /*shortest=*/0.05F)) {
      cuts += cut(*cloth, link) ? 1 : 0;
    }
    world.stepSimulation(btScalar(1) / 60, 0);
    crossings += world.detection().crossing_answers().unavoidable;
  }
  std::printf("%d links torn, %d faces instead of 800, %llu crossings\n", cuts, cloth->m_faces.size(), crossings);
  for (btSoftBody* body : {cloth.get(), ball.get()}) world.removeSoftBody(body);
}
