#include "scenes/deformable_simulation.hpp"

#include <algorithm>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletSoftBody/btDeformableBodySolver.h"
#include "BulletSoftBody/btDeformableGravityForce.h"
#include "BulletSoftBody/btDeformableMassSpringForce.h"
#include "BulletSoftBody/btDeformableMultiBodyConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"

namespace softcd::demo {
namespace {

const btVector3 kDeformableSimulationGravity(0, -10, 0);

}  // namespace

DeformableSimulation::DeformableSimulation(const std::optional<bullet::Settings>& settings,
                                           const DeformableMaterial& material)
    : configuration_(std::make_unique<btSoftBodyRigidBodyCollisionConfiguration>()),
      broadphase_(std::make_unique<btDbvtBroadphase>()),
      dispatcher_(std::make_unique<btCollisionDispatcher>(configuration_.get())),
      deformable_solver_(std::make_unique<btDeformableBodySolver>()),
      solver_(std::make_unique<btDeformableMultiBodyConstraintSolver>()),
      gravity_(std::make_unique<btDeformableGravityForce>(kDeformableSimulationGravity)),
      springs_(std::make_unique<btDeformableMassSpringForce>(material.elastic, material.damping,
                                                             /*conserve_angular=*/true, material.bending)) {
  solver_->setDeformableSolver(deformable_solver_.get());
  if (settings.has_value()) {
    auto world = std::make_unique<bullet::DeformableWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                           configuration_.get(), deformable_solver_.get(), *settings);
    detection_ = &world->detection();
    world_ = std::move(world);
  } else {
    world_ = std::make_unique<btDeformableMultiBodyDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                                  configuration_.get(), deformable_solver_.get());
  }
  set_gravity(kDeformableSimulationGravity);
}

DeformableSimulation::~DeformableSimulation() {
  for (const auto& body : soft_bodies_) world_->removeSoftBody(body.get());
  for (const auto& body : rigid_bodies_) world_->removeRigidBody(body.get());
}

btSoftBody& DeformableSimulation::add(std::unique_ptr<btSoftBody> body, int filter_group, int filter_mask) {
  using Flags = btSoftBody::fCollision;
  body->m_cfg.collisions = Flags::SDF_RD | Flags::SDF_RDN | Flags::VF_DD;
  body->m_cfg.kKHR = 1;
  body->m_cfg.kCHR = 1;
  world_->addSoftBody(body.get(), filter_group, filter_mask);
  world_->addForce(body.get(), gravity_.get());
  world_->addForce(body.get(), springs_.get());
  soft_bodies_.push_back(std::move(body));
  return *soft_bodies_.back();
}

std::unique_ptr<btSoftBody> DeformableSimulation::remove(btSoftBody& body) {
  const auto position =
      std::find_if(soft_bodies_.begin(), soft_bodies_.end(), [&](const auto& b) { return b.get() == &body; });
  world_->removeSoftBody(&body);
  std::unique_ptr<btSoftBody> removed = std::move(*position);
  soft_bodies_.erase(position);
  return removed;
}

btRigidBody& DeformableSimulation::add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center,
                                             btScalar mass) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape->calculateLocalInertia(mass, inertia);
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
  info.m_startWorldTransform.setOrigin(center);
  shapes_.push_back(std::move(shape));
  rigid_bodies_.push_back(std::make_unique<btRigidBody>(info));
  world_->addRigidBody(rigid_bodies_.back().get());
  return *rigid_bodies_.back();
}

void DeformableSimulation::set_gravity(const btVector3& gravity) {
  world_->setGravity(gravity);
  world_->getWorldInfo().m_gravity = gravity;
  gravity_->m_gravity = gravity;
}

void DeformableSimulation::step(btScalar seconds) {
  world_->stepSimulation(seconds, /*maxSubSteps=*/0);
}

}  // namespace softcd::demo
