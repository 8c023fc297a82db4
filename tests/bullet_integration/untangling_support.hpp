#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "attached_worlds.hpp"
#include "scenes/intersecting_bodies.hpp"
#include "scenes/penetration.hpp"

/// Bodies that start through each other, or through themselves, for tests of Settings::untangle.
namespace softcd::test {

inline constexpr int kMostSteps = 200;

inline bullet::Settings untangling(Detection detection, bullet::Untangle untangle = bullet::Untangle::all) {
  bullet::Settings settings = detection == Detection::ccd ? careful_settings() : cpu_settings();
  settings.self_collision = bullet::SelfCollision::all;
  settings.untangle = untangle;
  settings.untangle_speed = 1;
  return settings;
}

/// Intersecting bodies in a world without gravity.
class Tangle {
 public:
  Tangle(const char* name, World world, const bullet::Settings& settings, bool has_meshes = true)
      : Tangle(demo::find_intersecting_bodies(name), world, settings, has_meshes) {}
  /// `unit` is a metre in the units of length of the soft bodies.
  Tangle(const demo::IntersectingBodies& bodies, World world, const bullet::Settings& settings, bool has_meshes = true,
         btScalar unit = 1)
      : simulation_(world, settings) {
    simulation_.set_gravity(btVector3(0, 0, 0));
    simulation_.world().setGravity(btVector3(0, 0, 0));
    const demo::World kind = is_deformable(world) ? demo::World::deformable : demo::World::classic;
    for (auto& body : bodies.make(simulation_.world_info(), kind, 12)) {
      if (unit != 1) {
        body->scale(btVector3(unit, unit, unit));
        body->getCollisionShape()->setMargin(unit * body->getCollisionShape()->getMargin());
      }
      bodies_.push_back(&simulation_.add(std::move(body)));
    }
    meshes_.emplace(
        has_meshes ? bodies : demo::IntersectingBodies{},
        simulation_.world_info(), [this](auto shape, const btVector3& center, btScalar mass) -> auto& {
          return simulation_.add_rigid(std::move(shape), center, mass);
        });
  }

  void step() {
    simulation_.step();
    double energy = 0;
    for (const btSoftBody* body : bodies_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        const btSoftBody::Node& node = body->m_nodes[n];
        if (!(node.m_im > 0)) continue;
        energy += double(node.m_v.length2() / node.m_im) / 2;
        fastest_ = std::max(fastest_, double(node.m_v.length()));
      }
    }
    energy_ = std::max(energy_, energy);
  }
  /// Returns the number of steps after which nothing intersects, or kMostSteps.
  int steps_until_clean() {
    for (int steps = 1; steps < kMostSteps; ++steps) {
      step();
      if (pairs().empty() && edges() == 0) return steps;
    }
    return kMostSteps;
  }

  AnySimulation& simulation() { return simulation_; }
  const std::vector<bullet::IntersectingBodies>& pairs() { return simulation_.detection().intersecting_bodies(); }
  std::size_t edges() {
    std::vector<const btSoftBody*> all = bodies_;
    meshes_->append_copies(all);
    return demo::find_intersections(all).edge_count;
  }
  const std::vector<btRigidBody*>& rigid_bodies() const { return meshes_->bodies(); }
  double fastest() const { return fastest_; }
  double greatest_energy() const { return energy_; }
  double mass() const {
    double mass = 0;
    for (const btSoftBody* body : bodies_) mass += double(body->getTotalMass());
    return mass;
  }
  /// The velocity of the common centre of mass; 0 if something is held.
  double drift() const {
    btVector3 momentum(0, 0, 0);
    double mass = 0;
    for (const btRigidBody* body : rigid_bodies()) {
      if (!(body->getInvMass() > 0)) return 0;
      momentum += body->getLinearVelocity() / body->getInvMass();
      mass += 1 / double(body->getInvMass());
    }
    for (const btSoftBody* body : bodies_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        const btSoftBody::Node& node = body->m_nodes[n];
        if (!(node.m_im > 0)) return 0;
        momentum += node.m_v / node.m_im;
        mass += 1 / double(node.m_im);
      }
    }
    return double(momentum.length()) / mass;
  }

 private:
  AnySimulation simulation_;
  std::vector<const btSoftBody*> bodies_;
  std::optional<demo::RigidMeshes> meshes_;
  double fastest_ = 0, energy_ = 0;
};

/// Moves a body, at rest.
inline void shift(btSoftBody& body, const btVector3& offset) {
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    body.m_nodes[n].m_x += offset;
    body.m_nodes[n].m_q = body.m_nodes[n].m_x;
  }
}

inline std::string name_of_later(const testing::TestParamInfo<std::tuple<World, Detection>>& parameter) {
  const bool is_continuous = std::get<Detection>(parameter.param) == Detection::ccd;
  return name_of(std::get<World>(parameter.param)) + (is_continuous ? "_ccd" : "_dcd");
}

}  // namespace softcd::test
