#pragma once

#include <array>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "BulletSoftBody/btSoftMultiBodyDynamicsWorld.h"
#include "BulletSoftBody/btSoftRigidDynamicsWorld.h"
#include "deformable_support.hpp"

namespace softcd::test {

enum class World { one_line, multi_body, dispatcher, deformable, attached, attached_deformable };

inline bool is_deformable(World world) {
  return world == World::deformable || world == World::attached_deformable;
}

/// One of the set-ups, or without settings the world of Bullet's that it replaces.
class AnySimulation {
 public:
  /// `material` is of bodies in the deformable world.
  AnySimulation(World world, const std::optional<bullet::Settings>& settings,
                const demo::DeformableMaterial& material = {}) {
    const bool attaches = settings.has_value() && (world == World::attached || world == World::attached_deformable);
    if (is_deformable(world)) {
      deformable_ = std::make_unique<demo::DeformableSimulation>(attaches ? std::nullopt : settings, material);
    } else {
      const bool is_bullets = !settings.has_value() || attaches;
      const demo::PlugIn bullets = world == World::multi_body ? demo::PlugIn::none_multi_body : demo::PlugIn::none;
      const demo::PlugIn softcds = world == World::one_line     ? demo::PlugIn::one_line_world
                                   : world == World::multi_body ? demo::PlugIn::multi_body_world
                                                                : demo::PlugIn::dispatcher;
      classic_ =
          std::make_unique<demo::Simulation>(is_bullets ? bullets : softcds, settings.value_or(bullet::Settings()));
    }
    if (attaches) attach_again(*settings);
  }
  /// Detaches and attaches again, for worlds that softcd is attached to.
  void attach_again(const bullet::Settings& settings) {
    attachment_.reset();
    attachment_ = bullet::attach(world(), settings);
  }

  void detach() { attachment_->detach(); }

  btDiscreteDynamicsWorld& world() {
    return deformable_ != nullptr ? static_cast<btDiscreteDynamicsWorld&>(deformable_->world()) : classic_->world();
  }
  btCollisionDispatcher& dispatcher() { return static_cast<btCollisionDispatcher&>(*world().getDispatcher()); }
  const btAlignedObjectArray<btSoftBody*>& bodies() {
    if (deformable_ != nullptr) return deformable_->world().getSoftBodyArray();
    auto* multi_body = dynamic_cast<btSoftMultiBodyDynamicsWorld*>(&world());
    return multi_body != nullptr ? multi_body->getSoftBodyArray()
                                 : static_cast<btSoftRigidDynamicsWorld&>(world()).getSoftBodyArray();
  }
  btSoftBodyWorldInfo& world_info() {
    return deformable_ != nullptr ? deformable_->world_info() : classic_->world_info();
  }
  void set_gravity(const btVector3& gravity) {
    if (deformable_ != nullptr) deformable_->set_gravity(gravity);
    world_info().m_gravity = gravity;
  }
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass = 0) {
    return deformable_ != nullptr ? deformable_->add_rigid(std::move(shape), center, mass)
                                  : classic_->add_rigid(std::move(shape), center, mass);
  }
  btSoftBody& add(std::unique_ptr<btSoftBody> body) {
    return deformable_ != nullptr ? deformable_->add(std::move(body)) : classic_->add(std::move(body));
  }
  /// A sixtieth of a second. Bullet integrates the deformable world explicitly, in shorter steps; `before` is called
  /// before each, with its length.
  void step(const std::function<void(btScalar)>& before = [](btScalar) {}) {
    const int parts = deformable_ != nullptr ? 4 : 1;
    for (int i = 0; i < parts; ++i) {
      before(step_length());
      step(step_length());
    }
  }
  void step(btScalar seconds) {
    world().stepSimulation(seconds, /*maxSubSteps=*/0);
    finish_step();
  }
  /// A step in which the world is stable.
  void step_once() { step(step_length()); }
  btScalar step_length() const { return deformable_ != nullptr ? kStep / 4 : kStep; }
  /// After stepSimulation, where softcd is attached.
  void finish_step() {
    if (attachment_.has_value()) attachment_->finish_step();
  }
  std::unique_ptr<btSoftBody> remove(btSoftBody& body) {
    return deformable_ != nullptr ? deformable_->remove(body) : classic_->remove(body);
  }
  /// Destroys a classic world alone, with the bodies still in it.
  void destroy_world() { classic_->destroy_world(); }
  bullet::WorldDetection& detection() {
    if (attachment_.has_value()) return attachment_->detection();
    return deformable_ != nullptr ? *deformable_->detection() : *classic_->detection();
  }
  static int count_contacts(const btSoftBody& body) {
    return body.m_rcontacts.size() + body.m_nodeRigidContacts.size() + body.m_faceRigidContacts.size();
  }

 private:
  std::unique_ptr<demo::Simulation> classic_;
  std::unique_ptr<demo::DeformableSimulation> deformable_;
  std::optional<bullet::Attachment> attachment_;  ///< to either
};

/// Returns the sum of mass times that vector of each node.
inline btVector3 momentum(const btSoftBody& body, btVector3 btSoftBody::Node::*velocity) {
  btVector3 sum(0, 0, 0);
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    if (body.m_nodes[i].m_im > 0) sum += body.m_nodes[i].*velocity / body.m_nodes[i].m_im;
  }
  return sum;
}

/// Returns the momentum at the end of a step of `time`; `start` is the body's sum of mass times position before it. In
/// classic worlds the solver moves nodes. Bullet computes a body's velocities after solving it, but the contacts of
/// later bodies may still move its nodes.
inline btVector3 momentum_at_end(World world, const btSoftBody& body, const btVector3& start, btScalar time) {
  if (is_deformable(world)) return momentum(body, &btSoftBody::Node::m_v);
  return (momentum(body, &btSoftBody::Node::m_x) - start) / time;
}

inline std::string name_of(World world) {
  constexpr std::array kNames = {"one_line",   "multi_body", "dispatcher",
                                 "deformable", "attached",   "attached_deformable"};
  return kNames[static_cast<std::size_t>(world)];
}

/// Names parameterised tests.
inline std::string world_name(const testing::TestParamInfo<World>& parameter) {
  return name_of(parameter.param);
}

inline constexpr std::array kEveryWorld = {World::one_line,   World::multi_body, World::dispatcher,
                                           World::deformable, World::attached,   World::attached_deformable};
inline const auto kWorlds = testing::ValuesIn(kEveryWorld);

/// Returns these worlds, or those with a solver of their own where SOFTCD_FEW_WORLDS is set: for tests of bodies and
/// contacts. Tests of what makes a world run in all, and attached_worlds_test compares worlds byte for byte.
inline auto worlds_of_run(std::vector<World> worlds) {
  if (std::getenv("SOFTCD_FEW_WORLDS") != nullptr) {
    std::erase_if(worlds, [](World world) { return world != World::one_line && world != World::deformable; });
  }
  return testing::ValuesIn(worlds);
}
inline const auto kWorldsOfRun = worlds_of_run({kEveryWorld.begin(), kEveryWorld.end()});
inline const auto kClassicWorlds =
    worlds_of_run({World::one_line, World::multi_body, World::dispatcher, World::attached});
/// Worlds with crossing prevention after the solver. A world under a dispatcher has none.
inline const auto kLookingWorlds =
    worlds_of_run({World::one_line, World::multi_body, World::deformable, World::attached, World::attached_deformable});
/// Classic worlds with crossing prevention after the solver.
inline const auto kClassicLookingWorlds = worlds_of_run({World::one_line, World::multi_body, World::attached});

}  // namespace softcd::test
