// A kinematic triangle mesh pushes a curtain in front of it, however the app makes it kinematic and moves it: edges of
// either through faces of the other are counted in exact arithmetic.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "LinearMath/btDefaultMotionState.h"
#include "rigid_intersections.hpp"
#include "warned_simulation.hpp"

namespace softcd::test {
namespace {

constexpr int kKinematic = btCollisionObject::CF_KINEMATIC_OBJECT;
/// The flags after Bullet's usual way of making a body of mass 0 kinematic.
constexpr int kStaticAndKinematic = kKinematic | btCollisionObject::CF_STATIC_OBJECT;

/// Metres a second.
constexpr btScalar kSpeeds[] = {btScalar(0.25), 1, 5, 20};

constexpr btScalar kHalfDepth = btScalar(0.15);

RigidTriangles box(const btVector3& half) {
  const auto corner = [&](int i) {
    return btVector3((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                     (i & 4) != 0 ? half.z() : -half.z());
  };
  constexpr int kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  RigidTriangles triangles;
  for (const auto& side : kSides) {
    triangles.push_back({corner(side[0]), corner(side[1]), corner(side[2])});
    triangles.push_back({corner(side[0]), corner(side[2]), corner(side[3])});
  }
  return triangles;
}

/// Across z.
RigidTriangles wall_across_z() {
  const auto corner = [](int x, int y) { return btVector3(btScalar(2 * x), btScalar(2 * y), 0); };
  return {{corner(-1, -1), corner(1, -1), corner(-1, 1)}, {corner(1, -1), corner(1, 1), corner(-1, 1)}};
}

/// A mesh in a world, with its triangles.
struct AddedMesh {
  RigidTriangles triangles;
  std::unique_ptr<btTriangleMesh> source;
  btRigidBody* body = nullptr;
};

class KinematicMeshes : public WarnedSimulation {
 protected:
  explicit KinematicMeshes(const bullet::Settings& settings = careful_settings()) : WarnedSimulation(settings) {
    curtain = &hang_curtain(0);
    for (int n = 0; n < curtain->m_nodes.size(); ++n) starts.push_back(curtain->m_nodes[n].m_x);
  }

  /// Across z, held at its upper edge.
  btSoftBody& hang_curtain(btScalar z) {
    demo::ClothShape shape = demo::horizontal_cloth(11, 1, 0);
    shape.is_fixed = [](int i, int /*j*/) { return i == 0; };
    auto cloth = demo::make_cloth(simulation.world_info(), shape, 1);
    cloth->getCollisionShape()->setMargin(btScalar(0.02));
    cloth->m_cfg.kDP = btScalar(0.02);
    cloth->m_cfg.piterations = 4;
    const bool is_first_row_low = cloth->m_nodes[0].m_x.z() < 0;
    cloth->rotate(btQuaternion(btVector3(1, 0, 0), is_first_row_low ? SIMD_HALF_PI : -SIMD_HALF_PI));
    cloth->translate(btVector3(0, 0, z));
    cloth->setActivationState(DISABLE_DEACTIVATION);
    return simulation.add(std::move(cloth));
  }

  void add(AddedMesh& mesh, RigidTriangles triangles, const btVector3& place) {
    mesh.triangles = std::move(triangles);
    mesh.source = std::make_unique<btTriangleMesh>();
    for (const auto& [a, b, c] : mesh.triangles) mesh.source->addTriangle(a, b, c);
    auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.source.get(), /*quantised=*/true);
    shape->setMargin(btScalar(0.02));
    mesh.body = &simulation.add_rigid(std::move(shape), place);
  }
  /// `flags` are the body's flags as the app sets them.
  void add_walker(int flags) { add_walker(flags, box(btVector3(kHalfDepth, btScalar(0.4), kHalfDepth))); }
  void add_walker(int flags, const RigidTriangles& triangles) {
    add(walker, triangles, place_at(btScalar(-0.3)));
    walker.body->setCollisionFlags(flags);
    walker.body->setActivationState(DISABLE_DEACTIVATION);
  }
  static btVector3 place_at(btScalar z) { return {0, btScalar(-0.2), z}; }
  static btTransform pose_at(btScalar z) { return btTransform(btQuaternion::getIdentity(), place_at(z)); }

  /// Until it has stood at `end` for ten steps.
  template <class Move>
  void walk(btScalar speed, btScalar end, Move move) {
    btScalar z = walker.body->getWorldTransform().getOrigin().z();
    for (int steps_there = 0; steps_there < 10; steps_there += z < end ? 0 : 1) {
      simulation.step([&](btScalar seconds) {
        see();
        z = btMin(end, z + speed * seconds);
        move(pose_at(z));
      });
      see();
    }
  }
  void push_at_all_speeds(int flags, bool has_motion_state) {
    for (const btScalar speed : kSpeeds) {
      SCOPED_TRACE(speed);
      add_walker(flags);
      btDefaultMotionState state(pose_at(btScalar(-0.3)));
      if (has_motion_state) walker.body->setMotionState(&state);
      walk(speed, btScalar(0.3), [&](const btTransform& pose) {
        has_motion_state ? state.setWorldTransform(pose) : walker.body->setWorldTransform(pose);
      });
      expect_none_through();
      walker.body->setMotionState(nullptr);
      simulation.world().removeRigidBody(walker.body);
      put_curtain_back();
    }
    EXPECT_GT(answered, 0) << "something would have met";
  }
  void put_curtain_back() const {
    for (int n = 0; n < curtain->m_nodes.size(); ++n) {
      btSoftBody::Node& node = curtain->m_nodes[n];
      node.m_x = node.m_q = starts[static_cast<std::size_t>(n)];
      node.m_v.setZero();
    }
  }
  void see() {
    const bullet::CrossingAnswers answers = simulation.detection().crossing_answers();
    answered += answers.rounds > 0 || curtain->m_faceRigidContacts.size() > 0 ? 1 : 0;
    unavoidable += answers.unavoidable;
    excepted += answers.excepted;
    std::size_t edges = 0;
    for (const AddedMesh* mesh : {&walker, &obstacle}) {
      if (mesh->body == nullptr) continue;
      edges += count_intersections(*curtain, placed(mesh->triangles, mesh->body->getWorldTransform()));
    }
    most_edges = std::max(most_edges, edges);
    for (int n = 0; n < curtain->m_nodes.size(); ++n) fastest = btMax(fastest, curtain->m_nodes[n].m_v.length());
  }
  void expect_none_through() const {
    EXPECT_EQ(most_edges, 0U);
    EXPECT_EQ(unavoidable, 0U);
    EXPECT_EQ(excepted, 0U);
    EXPECT_TRUE(warnings.empty()) << warnings[0];
  }

  btSoftBody* curtain;
  std::vector<btVector3> starts;  ///< of its nodes
  AddedMesh walker, obstacle;
  std::size_t most_edges = 0;
  long answered = 0;  ///< steps in which something was in the way of what nodes' own contacts let through
  std::uint64_t unavoidable = 0, excepted = 0;
  btScalar fastest = 0;  ///< of the curtain's nodes
};
INSTANTIATE_TEST_SUITE_P(Worlds, KinematicMeshes, kLookingWorlds, world_name);

TEST_P(KinematicMeshes, push_a_curtain_as_static_and_kinematic_bodies) {
  push_at_all_speeds(kStaticAndKinematic, /*has_motion_state=*/false);
}
TEST_P(KinematicMeshes, push_a_curtain_as_static_and_kinematic_bodies_with_motion_states) {
  push_at_all_speeds(kStaticAndKinematic, /*has_motion_state=*/true);
}
TEST_P(KinematicMeshes, push_a_curtain_as_kinematic_bodies) {
  push_at_all_speeds(kKinematic, /*has_motion_state=*/false);
}

// Bullet saves velocities of kinematic bodies that are awake, and finds none where these are there already.
TEST_P(KinematicMeshes, push_a_curtain_where_bullet_knows_no_velocity) {
  for (const bool is_asleep : {true, false}) {
    SCOPED_TRACE(is_asleep);
    add_walker(kStaticAndKinematic);
    if (is_asleep) walker.body->forceActivationState(ISLAND_SLEEPING);
    simulation.step();  // where a mesh comes from is not known when it is new
    walk(10, btScalar(0.3), [&](const btTransform& pose) {
      EXPECT_TRUE(walker.body->getLinearVelocity().isZero()) << "given back";
      walker.body->setWorldTransform(pose);
      if (!is_asleep) walker.body->setInterpolationWorldTransform(pose);
    });
    expect_none_through();
    simulation.world().removeRigidBody(walker.body);
    put_curtain_back();
  }
  EXPECT_GT(answered, 0);
}

// The mesh moves by more than its own size, while Bullet knows no velocity of it.
TEST_P(KinematicMeshes, that_are_put_behind_a_curtain_leave_it_alone) {
  add_walker(kStaticAndKinematic);
  for (const btScalar z : {btScalar(-0.5), btScalar(-0.5), btScalar(0.5), btScalar(0.5)}) {
    walker.body->setWorldTransform(pose_at(z));
    walker.body->setInterpolationWorldTransform(pose_at(z));
    simulation.step([&](btScalar) { see(); });
    see();
  }
  EXPECT_EQ(answered, 0);
  EXPECT_LT(fastest, 1);
}

// By less than its own size. An app that deletes a mesh and makes another one may get its address again.
TEST_P(KinematicMeshes, that_were_removed_and_come_back_behind_a_curtain_leave_it_alone) {
  add_walker(kStaticAndKinematic);
  simulation.step([&](btScalar) { see(); });
  simulation.world().removeRigidBody(walker.body);
  walker.body->setWorldTransform(pose_at(btScalar(0.3)));
  walker.body->setInterpolationWorldTransform(pose_at(btScalar(0.3)));
  simulation.world().addRigidBody(walker.body);
  simulation.step([&](btScalar) { see(); });
  see();
  EXPECT_EQ(answered, 0);
  EXPECT_LT(fastest, 1);
}

// The curtain fits between the mesh and the wall.
TEST_P(KinematicMeshes, push_a_curtain_against_a_wall) {
  add_walker(kStaticAndKinematic);
  add(obstacle, wall_across_z(), btVector3(0, 0, btScalar(0.2)));
  walk(2, btScalar(0.2) - kHalfDepth - btScalar(0.05),
       [&](const btTransform& pose) { walker.body->setWorldTransform(pose); });
  expect_none_through();
}

/// At the default settings, discrete detection.
class KinematicMeshesAtTheDefault : public KinematicMeshes {
 protected:
  KinematicMeshesAtTheDefault() : KinematicMeshes(cpu_settings()) {}

  void push_slowly(const RigidTriangles& triangles) {
    for (const btScalar speed : {btScalar(0.25), btScalar(0.5), btScalar(1), btScalar(2)}) {
      SCOPED_TRACE(speed);
      add_walker(kStaticAndKinematic, triangles);
      walk(speed, btScalar(0.3), [&](const btTransform& pose) { walker.body->setWorldTransform(pose); });
      expect_none_through();
      simulation.world().removeRigidBody(walker.body);
      put_curtain_back();
    }
  }

  /// Counts edges within curtains that collide with themselves.
  void push_into_others(btScalar speed, btScalar end) {
    simulation.set_gravity(btVector3(0, -10, 0));
    std::vector<const btSoftBody*> curtains = {curtain};
    for (const btScalar z : {btScalar(0.4), btScalar(0.8)}) {
      btSoftBody& next = hang_curtain(z);
      next.setSelfCollision(curtain->useSelfCollision());
      curtains.push_back(&next);
    }
    add_walker(kStaticAndKinematic, box(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.03))));
    std::size_t most = 0;
    walk(speed, end, [&](const btTransform& pose) {
      const auto counts = [](const btSoftBody& a, const btSoftBody& b) { return &a != &b || a.m_useSelfCollision; };
      most = std::max(most, demo::find_intersections(curtains, counts).edge_count);
      walker.body->setWorldTransform(pose);
    });
    EXPECT_EQ(most, 0U) << "edges of curtains in curtains";
    expect_none_through();
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, KinematicMeshesAtTheDefault, kLookingWorlds, world_name);

// Its corners are between the nodes.
TEST_P(KinematicMeshesAtTheDefault, push_a_curtain_by_a_box) {
  for (const int iterations : {1, 4}) {
    SCOPED_TRACE(iterations);
    curtain->m_cfg.piterations = iterations;
    push_slowly(box(btVector3(kHalfDepth, btScalar(0.38), kHalfDepth)));
  }
}

// In the deformable world its contacts with itself push it after the solver has held it off meshes.
TEST_P(KinematicMeshesAtTheDefault, press_a_curtain_in_folds_against_a_wall) {
  constexpr btScalar kWall = btScalar(0.12);
  curtain->setSelfCollision(true);
  for (int n = 0; n < curtain->m_nodes.size(); ++n) {
    btSoftBody::Node& node = curtain->m_nodes[n];
    node.m_x.setX(node.m_x.x() * btScalar(0.7));
    node.m_x.setZ(btScalar(n / 11 % 2) * btScalar(0.07));
    node.m_q = node.m_x;
  }
  add(obstacle, wall_across_z(), btVector3(0, 0, kWall));
  add_walker(kStaticAndKinematic);
  for (const btScalar gap : {btScalar(0.05), btScalar(0.04), btScalar(0.03)}) {
    SCOPED_TRACE(gap);
    walk(1, kWall - kHalfDepth - gap, [&](const btTransform& pose) { walker.body->setWorldTransform(pose); });
    expect_none_through();
  }
}

TEST_P(KinematicMeshesAtTheDefault, push_a_curtain_by_the_tip_of_a_spike) {
  const btVector3 tip(btScalar(0.04), btScalar(-0.24), kHalfDepth);
  RigidTriangles spike;
  for (int i = 0; i < 3; ++i) {
    const auto base = [&](int corner) {
      const btScalar angle = SIMD_2_PI * btScalar(corner) / 3;
      return tip + btVector3(btCos(angle) / 50, btSin(angle) / 50, btScalar(-0.3));
    };
    spike.push_back({tip, base(i), base(i + 1)});
  }
  push_slowly(spike);
}

// The last pass keeps a curtain out of the mesh, and so moves it towards the next one. That one moves towards the
// third, which is not near the mesh.
TEST_P(KinematicMeshesAtTheDefault, push_a_curtain_into_others) {
  if (is_deformable(GetParam())) GTEST_SKIP() << "Bullet's solver itself pushes such curtains through each other";
  push_into_others(2, btScalar(0.9));
}

// The last pass also moves a curtain through itself, where it is crumpled between the mesh and the next curtain.
TEST_P(KinematicMeshesAtTheDefault, push_curtains_that_collide_with_themselves) {
  if (is_deformable(GetParam())) GTEST_SKIP() << "Bullet's solver itself pushes such curtains through each other";
  curtain->setSelfCollision(true);
  push_into_others(2, btScalar(1.2));
}

// Bullet collides the curtain with meshes, also if it collides with no soft bodies.
TEST_P(KinematicMeshesAtTheDefault, push_a_curtain_that_collides_with_rigid_bodies_alone) {
  curtain->m_cfg.collisions &= ~(btSoftBody::fCollision::VF_SS | btSoftBody::fCollision::VF_DD);
  push_slowly(box(btVector3(kHalfDepth, btScalar(0.38), kHalfDepth)));
}

}  // namespace
}  // namespace softcd::test
