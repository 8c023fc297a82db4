#include "scenes/soft_world.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace softcd::demo {
namespace {

constexpr btScalar kClassicStep = btScalar(1) / 120;
// Bullet integrates springs explicitly in the deformable world. With DeformableMaterial and these masses, the fastest
// oscillation of a cloth, of angular frequency sqrt(8 k / m), moves by 0.65 radians in a step; 2 would be unstable.
constexpr btScalar kDeformableStep = btScalar(1) / 240;
constexpr btScalar kDeformableNodeMass = btScalar(0.01);

void give_stable_masses(btSoftBody& body) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    if (body.m_nodes[i].m_im > 0) body.setMass(i, kDeformableNodeMass);
  }
}

template <class Count>
std::size_t sum_over(const std::vector<btSoftBody*>& bodies, Count count) {
  std::size_t sum = 0;
  for (const btSoftBody* body : bodies) sum += static_cast<std::size_t>(count(*body));
  return sum;
}

}  // namespace

SoftWorld::SoftWorld(World kind, PlugIn plug_in, const bullet::Settings& settings) {
  if (kind == World::classic) {
    classic_ = std::make_unique<Simulation>(plug_in, settings);
  } else {
    deformable_ = std::make_unique<DeformableSimulation>(plug_in == PlugIn::none || plug_in == PlugIn::none_multi_body
                                                             ? std::nullopt
                                                             : std::optional<bullet::Settings>(settings));
  }
}

btSoftBodyWorldInfo& SoftWorld::world_info() {
  return classic_ != nullptr ? classic_->world_info() : deformable_->world_info();
}

btSoftBody& SoftWorld::add(std::unique_ptr<btSoftBody> body) {
  if (deformable_ != nullptr) give_stable_masses(*body);
  body->setActivationState(DISABLE_DEACTIVATION);
  bodies_.push_back(classic_ != nullptr ? &classic_->add(std::move(body)) : &deformable_->add(std::move(body)));
  return *bodies_.back();
}

btRigidBody& SoftWorld::add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass) {
  return classic_ != nullptr ? classic_->add_rigid(std::move(shape), center, mass)
                             : deformable_->add_rigid(std::move(shape), center, mass);
}

void SoftWorld::set_gravity(const btVector3& gravity) {
  if (classic_ != nullptr) {
    classic_->set_gravity(gravity);
  } else {
    deformable_->set_gravity(gravity);
  }
}

void SoftWorld::stop_soft_contacts() {
  for (btSoftBody* body : bodies_) {
    body->m_cfg.collisions &= ~(btSoftBody::fCollision::VF_SS | btSoftBody::fCollision::VF_DD);
  }
}

void SoftWorld::step(btScalar seconds) {
  if (classic_ != nullptr) {
    classic_->step(seconds);
  } else {
    deformable_->step(seconds);
  }
}

btScalar SoftWorld::time_step() const {
  return classic_ != nullptr ? kClassicStep : kDeformableStep;
}

const bullet::WorldDetection* SoftWorld::detection() const {
  return classic_ != nullptr ? classic_->detection() : deformable_->detection();
}

bullet::WorldDetection* SoftWorld::detection() {
  return classic_ != nullptr ? classic_->detection() : deformable_->detection();
}

std::size_t SoftWorld::count_soft_contacts() const {
  return sum_over(bodies_, [](const btSoftBody& b) { return b.m_scontacts.size() + b.m_faceNodeContacts.size(); });
}

std::size_t SoftWorld::count_rigid_contacts() const {
  return sum_over(bodies_, [](const btSoftBody& b) {
    return b.m_rcontacts.size() + b.m_nodeRigidContacts.size() + b.m_faceRigidContacts.size();
  });
}

}  // namespace softcd::demo
