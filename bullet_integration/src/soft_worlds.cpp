#include "softcd/bullet/soft_worlds.hpp"

#include "soft_world_hooks.hpp"

namespace softcd::bullet {

SoftRigidDynamicsWorld::SoftRigidDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                                               btConstraintSolver* solver, btCollisionConfiguration* configuration,
                                               btSoftBodySolver* soft_body_solver, const Settings& settings)
    : btSoftRigidDynamicsWorld(dispatcher, broadphase, solver, configuration, soft_body_solver),
      hooks_(std::make_unique<SoftWorldHooks>(dispatcher, settings)) {}

SoftRigidDynamicsWorld::~SoftRigidDynamicsWorld() = default;

void SoftRigidDynamicsWorld::predictUnconstraintMotion(btScalar time_step) {
  hooks_->predict(getSoftBodyArray(), [&] { btSoftRigidDynamicsWorld::predictUnconstraintMotion(time_step); });
}

void SoftRigidDynamicsWorld::performDiscreteCollisionDetection() {
  hooks_->detect(*this, getSoftBodyArray());
}

void SoftRigidDynamicsWorld::internalSingleStepSimulation(btScalar time_step) {
  btSoftRigidDynamicsWorld::internalSingleStepSimulation(time_step);
  hooks_->prevent_crossings(*this, getSoftBodyArray(), time_step);
}

const Settings& SoftRigidDynamicsWorld::settings() const {
  return hooks_->settings();
}

void SoftRigidDynamicsWorld::set_settings(const Settings& settings) {
  hooks_->set_settings(settings);
}

const CollisionPipeline& SoftRigidDynamicsWorld::pipeline() const {
  return hooks_->pipeline();
}

const std::vector<EdgeContact>& SoftRigidDynamicsWorld::edge_contacts() const {
  return hooks_->edge_contacts();
}

SoftMultiBodyDynamicsWorld::SoftMultiBodyDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                                                       btMultiBodyConstraintSolver* solver,
                                                       btCollisionConfiguration* configuration,
                                                       btSoftBodySolver* soft_body_solver, const Settings& settings)
    : btSoftMultiBodyDynamicsWorld(dispatcher, broadphase, solver, configuration, soft_body_solver),
      hooks_(std::make_unique<SoftWorldHooks>(dispatcher, settings)) {}

SoftMultiBodyDynamicsWorld::~SoftMultiBodyDynamicsWorld() = default;

void SoftMultiBodyDynamicsWorld::predictUnconstraintMotion(btScalar time_step) {
  hooks_->predict(getSoftBodyArray(), [&] { btSoftMultiBodyDynamicsWorld::predictUnconstraintMotion(time_step); });
}

void SoftMultiBodyDynamicsWorld::performDiscreteCollisionDetection() {
  hooks_->detect(*this, getSoftBodyArray());
}

void SoftMultiBodyDynamicsWorld::internalSingleStepSimulation(btScalar time_step) {
  btSoftMultiBodyDynamicsWorld::internalSingleStepSimulation(time_step);
  hooks_->prevent_crossings(*this, getSoftBodyArray(), time_step);
}

const Settings& SoftMultiBodyDynamicsWorld::settings() const {
  return hooks_->settings();
}

void SoftMultiBodyDynamicsWorld::set_settings(const Settings& settings) {
  hooks_->set_settings(settings);
}

const CollisionPipeline& SoftMultiBodyDynamicsWorld::pipeline() const {
  return hooks_->pipeline();
}

const std::vector<EdgeContact>& SoftMultiBodyDynamicsWorld::edge_contacts() const {
  return hooks_->edge_contacts();
}

}  // namespace softcd::bullet
