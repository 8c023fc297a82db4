#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"
#include "deformable_app_support.hpp"
#include "small_scenes.hpp"
#include "softcd/bullet/attach.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::test {

enum class Kind { soft_rigid, multi_body, deformable };

inline const auto kKindsOfWorld = testing::Values(Kind::soft_rigid, Kind::multi_body, Kind::deformable);

inline std::string name_of(Kind kind) {
  constexpr std::array kNames = {"soft_rigid", "multi_body", "deformable"};
  return kNames[static_cast<std::size_t>(kind)];
}

/// One of Bullet's worlds with soft bodies, as somebody else makes it, or softcd's own of that kind.
class ForeignWorld {
 public:
  explicit ForeignWorld(Kind kind, const MaybeSettings& of_softcds_own = std::nullopt) {
    if (kind == Kind::deformable) {
      deformable_ = std::make_unique<demo::DeformableSimulation>(of_softcds_own);
    } else {
      broadphase_ = std::make_unique<btDbvtBroadphase>();
      make_classic(kind, of_softcds_own);
      world_->setGravity(btVector3(0, -10, 0));
      info().m_gravity = btVector3(0, -10, 0);
    }
  }
  ~ForeignWorld() {
    if (world_ == nullptr) return;
    for (const auto& body : bodies_) world_->removeCollisionObject(body.get());
    for (const auto& body : rigid_) world_->removeRigidBody(body.get());
  }
  ForeignWorld(const ForeignWorld&) = delete;
  ForeignWorld& operator=(const ForeignWorld&) = delete;

  btDiscreteDynamicsWorld& world() {
    return deformable_ != nullptr ? static_cast<btDiscreteDynamicsWorld&>(deformable_->world()) : *world_;
  }
  btSoftBodyWorldInfo& info() { return deformable_ != nullptr ? deformable_->world_info() : *info_; }
  const btAlignedObjectArray<btSoftBody*>& bodies() {
    return deformable_ != nullptr ? deformable_->world().getSoftBodyArray() : *soft_bodies_;
  }
  /// Null in softcd's deformable world, and where Bullet detects.
  bullet::WorldDetection* own_detection() { return deformable_ != nullptr ? deformable_->detection() : detection_; }
  btCollisionDispatcher& dispatcher() { return static_cast<btCollisionDispatcher&>(*world().getDispatcher()); }

  btSoftBody& add(std::unique_ptr<btSoftBody> body) {
    body->setActivationState(DISABLE_DEACTIVATION);
    if (deformable_ != nullptr) return deformable_->add(std::move(body));
    if (auto* world = dynamic_cast<btSoftRigidDynamicsWorld*>(world_.get())) {
      world->addSoftBody(body.get());
    } else {
      static_cast<btSoftMultiBodyDynamicsWorld&>(*world_).addSoftBody(body.get());
    }
    bodies_.push_back(std::move(body));
    return *bodies_.back();
  }
  std::unique_ptr<btSoftBody> remove(btSoftBody& body) {
    if (deformable_ != nullptr) return deformable_->remove(body);
    world_->removeCollisionObject(&body);
    const auto position = std::find_if(bodies_.begin(), bodies_.end(), [&](const auto& b) { return b.get() == &body; });
    std::unique_ptr<btSoftBody> removed = std::move(*position);
    bodies_.erase(position);
    return removed;
  }
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center) {
    if (deformable_ != nullptr) return deformable_->add_rigid(std::move(shape), center);
    btRigidBody::btRigidBodyConstructionInfo rigid(0, nullptr, shape.get());
    rigid.m_startWorldTransform.setOrigin(center);
    shapes_.push_back(std::move(shape));
    rigid_.push_back(std::make_unique<btRigidBody>(rigid));
    world_->addRigidBody(rigid_.back().get());
    return *rigid_.back();
  }
  btScalar step_length() const { return deformable_ != nullptr ? kShortStep : kStep; }
  void step() { world().stepSimulation(step_length(), 0); }
  /// Destroys the world without removing anything from it before.
  void destroy_world() { world_.reset(); }

 private:
  void make_classic(Kind kind, const MaybeSettings& settings) {
    if (kind == Kind::soft_rigid && settings.has_value()) {
      keep(std::make_unique<bullet::SoftRigidDynamicsWorld>(&dispatcher_, broadphase_.get(), &plain_solver_,
                                                            &configuration_, nullptr, *settings));
    } else if (kind == Kind::soft_rigid) {
      keep(
          std::make_unique<btSoftRigidDynamicsWorld>(&dispatcher_, broadphase_.get(), &plain_solver_, &configuration_));
    } else if (settings.has_value()) {
      keep(std::make_unique<bullet::SoftMultiBodyDynamicsWorld>(&dispatcher_, broadphase_.get(), &solver_,
                                                                &configuration_, nullptr, *settings));
    } else {
      keep(std::make_unique<btSoftMultiBodyDynamicsWorld>(&dispatcher_, broadphase_.get(), &solver_, &configuration_));
    }
  }
  template <class World>
  void keep(std::unique_ptr<World> world) {
    info_ = &world->getWorldInfo();
    soft_bodies_ = &world->getSoftBodyArray();
    if constexpr (std::is_base_of_v<bullet::SoftRigidDynamicsWorld, World> ||
                  std::is_base_of_v<bullet::SoftMultiBodyDynamicsWorld, World>) {
      detection_ = &world->detection();
    }
    world_ = std::move(world);
  }

  std::unique_ptr<demo::DeformableSimulation> deformable_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btSequentialImpulseConstraintSolver plain_solver_;
  btMultiBodyConstraintSolver solver_;
  std::unique_ptr<btDbvtBroadphase> broadphase_;
  std::vector<std::unique_ptr<btSoftBody>> bodies_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> rigid_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  btSoftBodyWorldInfo* info_ = nullptr;
  const btAlignedObjectArray<btSoftBody*>* soft_bodies_ = nullptr;
  bullet::WorldDetection* detection_ = nullptr;
};

}  // namespace softcd::test
