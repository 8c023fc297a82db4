#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
// g++ 12 takes a default argument in a template that these instantiate for uninitialised.
#pragma GCC diagnostic push
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include "BulletSoftBody/btDeformableBodySolver.h"
#include "BulletSoftBody/btDeformableMultiBodyConstraintSolver.h"
#pragma GCC diagnostic pop
#include "BulletSoftBody/btDeformableGravityForce.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "deformable_support.hpp"

/// Shared by the tests of apps' settings in the deformable world. Each test runs with softcd and with Bullet alone.
namespace softcd::test {

/// Bullet moves the nodes of the deformable world explicitly.
inline constexpr btScalar kShortStep = btScalar(1) / 240;

/// None for Bullet's own world.
using MaybeSettings = std::optional<bullet::Settings>;
/// Node's body, node, face's body, face: places in the world's and the bodies' arrays.
using NodeFaceSet = std::set<std::array<int, 4>>;

inline int count_contacts(const btAlignedObjectArray<btSoftBody*>& bodies) {
  int count = 0;
  for (int b = 0; b < bodies.size(); ++b) count += bodies[b]->m_faceNodeContacts.size();
  return count;
}

inline NodeFaceSet contacts_in(const btAlignedObjectArray<btSoftBody*>& bodies) {
  NodeFaceSet result;
  for (int b = 0; b < bodies.size(); ++b) {
    for (int i = 0; i < bodies[b]->m_faceNodeContacts.size(); ++i) {
      const btSoftBody::DeformableFaceNodeContact& contact = bodies[b]->m_faceNodeContacts[i];
      int face_body = 0;
      while (bodies[face_body] != contact.m_colObj) ++face_body;
      result.insert({b, static_cast<int>(contact.m_node - &bodies[b]->m_nodes[0]), face_body,
                     static_cast<int>(contact.m_face - &bodies[face_body]->m_faces[0])});
    }
  }
  return result;
}

/// Bullet's trees miss some contacts at the borders of boxes.
inline void expect_bullets_contacts(const NodeFaceSet& ours, const NodeFaceSet& bullets) {
  EXPECT_TRUE(std::includes(ours.begin(), ours.end(), bullets.begin(), bullets.end())) << "one that only Bullet has";
  EXPECT_LE(ours.size(), bullets.size() + bullets.size() / 5);
}

/// Horizontal sheets that start every step where they were made: its contacts do not depend on the step before.
class HeldSheets {
 public:
  explicit HeldSheets(const MaybeSettings& settings) : simulation_(settings) {}

  btSoftBody& add(btScalar height, int group = 1, int mask = -1) {
    SheetOptions options;
    options.height = height;
    options.margin = btScalar(0.02);
    return add(make_sheet(simulation_.world_info(), options), group, mask);
  }
  btSoftBody& add(std::unique_ptr<btSoftBody> made, int group = 1, int mask = -1) {
    btSoftBody& body = simulation_.add(std::move(made), group, mask);
    hold(body);
    return body;
  }
  std::unique_ptr<btSoftBody> remove(btSoftBody& body) {
    places_.erase(&body);
    return simulation_.remove(body);
  }
  /// Saves the nodes' present positions as their start.
  void hold(btSoftBody& body) {
    std::vector<btVector3>& places = places_[&body];
    places.clear();
    for (int n = 0; n < body.m_nodes.size(); ++n) places.push_back(body.m_nodes[n].m_x);
  }

  /// The contacts of one more step.
  NodeFaceSet step() {
    for (const auto& [body, places] : places_) {
      for (std::size_t n = 0; n < places.size(); ++n) {
        btSoftBody::Node& node = body->m_nodes[static_cast<int>(n)];
        node.m_x = node.m_q = places[n];
        node.m_v.setZero();
      }
    }
    simulation_.step(kStep);
    return contacts_in(bodies());
  }

  demo::DeformableSimulation& simulation() { return simulation_; }
  const btAlignedObjectArray<btSoftBody*>& bodies() { return simulation_.world().getSoftBodyArray(); }

 private:
  demo::DeformableSimulation simulation_;
  std::map<btSoftBody*, std::vector<btVector3>> places_;
};

/// Two sheets in contact.
struct TwoHeldSheets : HeldSheets {
  btSoftBody& lower;
  btSoftBody& upper;

  explicit TwoHeldSheets(const MaybeSettings& settings, int group_a = 1, int mask_a = -1, int group_b = 1,
                         int mask_b = -1)
      : HeldSheets(settings), lower(add(0, group_a, mask_a)), upper(add(btScalar(0.03), group_b, mask_b)) {}
};

using Steps = std::vector<NodeFaceSet>;

/// Steps with contacts where `touching` says, as with Bullet.
inline void expect_steps_as_bullets(const std::function<Steps(const MaybeSettings&)>& run,
                                    const std::vector<bool>& touching) {
  const Steps bullets = run(std::nullopt);
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const Steps ours = run(cpu_settings(detection));
    ASSERT_EQ(ours.size(), touching.size());
    for (std::size_t i = 0; i < touching.size(); ++i) {
      SCOPED_TRACE("part " + std::to_string(i));
      EXPECT_EQ(!ours[i].empty(), touching[i]);
      expect_bullets_contacts(ours[i], bullets[i]);
    }
  }
}

inline void expect_as_bullets(const std::function<double(const MaybeSettings&)>& outcome, double tolerance) {
  EXPECT_NEAR(outcome(cpu_settings()), outcome(std::nullopt), tolerance);
}

inline std::unique_ptr<btSoftBody> make_small_sheet(btSoftBodyWorldInfo& info, btScalar height, bool fixed = false) {
  SheetOptions options;
  options.height = height;
  options.margin = btScalar(0.02);
  options.fixed = fixed;
  return make_sheet(info, options);
}

/// A deformable world of parts that the app chose.
struct OwnWorld {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  std::unique_ptr<btBroadphaseInterface> broadphase = std::make_unique<btDbvtBroadphase>();
  std::unique_ptr<btCollisionDispatcher> dispatcher = std::make_unique<btCollisionDispatcher>(&configuration);
  std::unique_ptr<btDeformableBodySolver> deformable_solver = std::make_unique<btDeformableBodySolver>();
  btDeformableMultiBodyConstraintSolver solver;
  btDeformableGravityForce gravity{btVector3(0, -10, 0)};
  std::unique_ptr<btDeformableMultiBodyDynamicsWorld> world;

  void make(const MaybeSettings& settings) {
    solver.setDeformableSolver(deformable_solver.get());
    if (settings.has_value()) {
      world = std::make_unique<bullet::DeformableWorld>(dispatcher.get(), broadphase.get(), &solver, &configuration,
                                                        deformable_solver.get(), *settings);
    } else {
      world = std::make_unique<btDeformableMultiBodyDynamicsWorld>(dispatcher.get(), broadphase.get(), &solver,
                                                                   &configuration, deformable_solver.get());
    }
    world->setGravity(gravity.m_gravity);
    world->getWorldInfo().m_gravity = gravity.m_gravity;
  }
  btSoftBody& add(std::unique_ptr<btSoftBody> body, int flags = btSoftBody::fCollision::SDF_RD |
                                                                btSoftBody::fCollision::SDF_RDN |
                                                                btSoftBody::fCollision::VF_DD) {
    body->m_cfg.collisions = flags;
    body->m_cfg.kKHR = body->m_cfg.kCHR = 1;
    world->addSoftBody(body.get());
    if (!body->m_reducedModel) world->addForce(body.get(), &gravity);
    bodies.push_back(std::move(body));
    return *bodies.back();
  }
  ~OwnWorld() {
    for (const auto& body : bodies) world->removeSoftBody(body.get());
  }

  std::vector<std::unique_ptr<btSoftBody>> bodies;
};

}  // namespace softcd::test
