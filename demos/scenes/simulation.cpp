#include "scenes/simulation.hpp"

#include <algorithm>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "softcd/bullet/dispatcher.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::demo {
namespace {

const btVector3 kSimulationGravity(0, -10, 0);

}  // namespace

Simulation::Simulation(PlugIn plug_in, const bullet::Settings& settings)
    : configuration_(std::make_unique<btSoftBodyRigidBodyCollisionConfiguration>()),
      solver_(std::make_unique<btMultiBodyConstraintSolver>()) {
  make_world(plug_in, settings);
  set_gravity(kSimulationGravity);
  world_info_->m_broadphase = broadphase_.get();
  world_info_->m_dispatcher = dispatcher_.get();
}

void Simulation::make_world(PlugIn plug_in, const bullet::Settings& settings) {
  if (plug_in == PlugIn::dispatcher) {
    auto broadphase = std::make_unique<bullet::Broadphase>(std::make_unique<btDbvtBroadphase>());
    auto dispatcher = std::make_unique<bullet::Dispatcher>(configuration_.get(), *broadphase, settings);
    detection_ = &dispatcher->detection();
    broadphase_ = std::move(broadphase);
    dispatcher_ = std::move(dispatcher);
  } else {
    broadphase_ = std::make_unique<btDbvtBroadphase>();
    dispatcher_ = std::make_unique<btCollisionDispatcher>(configuration_.get());
  }

  if (plug_in == PlugIn::multi_body_world) {
    auto world = std::make_unique<bullet::SoftMultiBodyDynamicsWorld>(
        dispatcher_.get(), broadphase_.get(), solver_.get(), configuration_.get(), nullptr, settings);
    detection_ = &world->detection();
    use(std::move(world));
    return;
  }
  if (plug_in == PlugIn::none_multi_body) {
    use(std::make_unique<btSoftMultiBodyDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                       configuration_.get()));
    return;
  }
  if (plug_in == PlugIn::one_line_world) {
    auto world = std::make_unique<bullet::SoftRigidDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                                  configuration_.get(), nullptr, settings);
    detection_ = &world->detection();
    soft_rigid_world_ = world.get();
    world_ = std::move(world);
  } else {
    auto world = std::make_unique<btSoftRigidDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                            configuration_.get());
    soft_rigid_world_ = world.get();
    world_ = std::move(world);
  }
  if (plug_in == PlugIn::attached) {
    attachment_ = bullet::attach(*world_, settings);
    detection_ = &attachment_->detection();
  }
  world_info_ = &soft_rigid_world_->getWorldInfo();
}

void Simulation::use(std::unique_ptr<btSoftMultiBodyDynamicsWorld> world) {
  soft_multi_body_world_ = world.get();
  world_info_ = &world->getWorldInfo();
  world_ = std::move(world);
}

void Simulation::destroy_world() {
  world_.reset();
}

Simulation::~Simulation() {
  if (world_ == nullptr) return;
  for (const auto& body : soft_bodies_) world_->removeCollisionObject(body.get());
  for (const auto& body : rigid_bodies_) world_->removeRigidBody(body.get());
}

btSoftBody& Simulation::add(std::unique_ptr<btSoftBody> body, int filter_group, int filter_mask) {
  if (soft_rigid_world_ != nullptr) {
    soft_rigid_world_->addSoftBody(body.get(), filter_group, filter_mask);
  } else {
    soft_multi_body_world_->addSoftBody(body.get(), filter_group, filter_mask);
  }
  soft_bodies_.push_back(std::move(body));
  return *soft_bodies_.back();
}

std::unique_ptr<btSoftBody> Simulation::remove(btSoftBody& body) {
  const auto position =
      std::find_if(soft_bodies_.begin(), soft_bodies_.end(), [&](const auto& b) { return b.get() == &body; });
  world_->removeCollisionObject(&body);
  std::unique_ptr<btSoftBody> removed = std::move(*position);
  soft_bodies_.erase(position);
  return removed;
}

btRigidBody& Simulation::add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape->calculateLocalInertia(mass, inertia);
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
  info.m_startWorldTransform.setOrigin(center);
  shapes_.push_back(std::move(shape));
  rigid_bodies_.push_back(std::make_unique<btRigidBody>(info));
  world_->addRigidBody(rigid_bodies_.back().get());
  return *rigid_bodies_.back();
}

btRigidBody& Simulation::add_static_box(const btVector3& half_extents, const btVector3& center) {
  return add_rigid(std::make_unique<btBoxShape>(half_extents), center);
}

void Simulation::set_gravity(const btVector3& gravity) {
  world_->setGravity(gravity);
  world_info_->m_gravity = gravity;
}

void Simulation::step(btScalar seconds) {
  world_->stepSimulation(seconds, /*maxSubSteps=*/0);
  if (attachment_.has_value()) attachment_->finish_step();
}

}  // namespace softcd::demo
