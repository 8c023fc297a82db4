// Rays through softcd's worlds, as apps cast them, compared with Bullet's own ray tests of the same bodies.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/Dynamics/btActionInterface.h"
#include "any_simulation.hpp"
#include "failing_allocations.hpp"
#include "random.hpp"
#include "scenes/cloth.hpp"
#include "softcd/bullet/deformable_world.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::test {
namespace {

/// A hit of one object, as a callback received it.
struct ReportedHit {
  const btCollisionObject* object;
  int part, triangle;
  btVector3 normal;
  btScalar fraction;
};

/// Records all hits, the nearest first.
struct RayListener : btCollisionWorld::RayResultCallback {
  std::vector<ReportedHit> told;
  bool keeps_nearest = false;

  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool is_in_world_space) override {
    EXPECT_TRUE(is_in_world_space || !result.m_collisionObject->getCollisionShape()->isSoftBody());
    const btCollisionWorld::LocalShapeInfo* shape = result.m_localShapeInfo;
    told.push_back({result.m_collisionObject, shape != nullptr ? shape->m_shapePart : -1,
                    shape != nullptr ? shape->m_triangleIndex : -1, result.m_hitNormalLocal, result.m_hitFraction});
    std::sort(told.begin(), told.end(),
              [](const ReportedHit& a, const ReportedHit& b) { return a.fraction < b.fraction; });
    if (keeps_nearest) m_closestHitFraction = result.m_hitFraction;
    m_collisionObject = result.m_collisionObject;
    return m_closestHitFraction;
  }
};

/// Bullet's own, in whichever of softcd's worlds.
void bullets_ray_test(const btDiscreteDynamicsWorld& world, const btVector3& from, const btVector3& to,
                      btCollisionWorld::RayResultCallback& callback) {
  if (const auto* classic = dynamic_cast<const btSoftRigidDynamicsWorld*>(&world)) {
    classic->btSoftRigidDynamicsWorld::rayTest(from, to, callback);
  } else if (const auto* multi_body = dynamic_cast<const btSoftMultiBodyDynamicsWorld*>(&world)) {
    multi_body->btSoftMultiBodyDynamicsWorld::rayTest(from, to, callback);
  } else {
    dynamic_cast<const btDeformableMultiBodyDynamicsWorld&>(world).btDeformableMultiBodyDynamicsWorld::rayTest(
        from, to, callback);
  }
}

class RayTests : public testing::TestWithParam<World> {
 protected:
  AnySimulation simulation{GetParam(), cpu_settings()};

  btSoftBody& add_sheet(btScalar height) {
    SheetOptions options;
    options.height = height;
    options.fixed = true;
    return simulation.add(make_sheet(simulation.world_info(), options));
  }

  RayListener told(const btVector3& from, const btVector3& to) {
    RayListener listener;
    simulation.world().rayTest(from, to, listener);
    return listener;
  }

  /// From high above straight down.
  std::vector<const btCollisionObject*> objects_below(btScalar x, btScalar z) {
    std::vector<const btCollisionObject*> objects;
    for (const ReportedHit& one : told({x, 10, z}, {x, -10, z}).told) objects.push_back(one.object);
    return objects;
  }
};

const btVector3 kHigh(btScalar(0.11), 10, btScalar(0.07));
const btVector3 kLow(btScalar(0.11), -10, btScalar(0.07));

TEST_P(RayTests, tell_what_bullets_tell) {
  add_sheet(0);
  btSoftBody& ball = simulation.add(demo::make_ball(simulation.world_info(), btVector3(0, 1, 0), btScalar(0.5), 2));
  simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, btScalar(0.1), 1)), btVector3(0, -1, 0));
  simulation.step();
  ball.updateNormals();
  Random random(3);
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const auto point = [&](double size) {
      const Vec3d p = random.in_box(size);
      return btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z));
    };
    const btVector3 from = point(3);
    const btVector3 to = from + 3 * (point(0.7) - from);
    for (const bool keeps_nearest : {false, true}) {
      RayListener ours, bullets;
      ours.keeps_nearest = bullets.keeps_nearest = keeps_nearest;
      simulation.world().rayTest(from, to, ours);
      bullets_ray_test(simulation.world(), from, to, bullets);
      ASSERT_EQ(ours.hasHit(), bullets.hasHit()) << "ray " << i;
      if (!ours.hasHit()) continue;
      const std::size_t count = keeps_nearest ? 1 : ours.told.size();
      ASSERT_TRUE(keeps_nearest || bullets.told.size() == count) << "ray " << i;
      for (std::size_t j = 0; j < count; ++j) {
        ASSERT_EQ(ours.told[j].object, bullets.told[j].object) << "ray " << i;
        EXPECT_EQ(ours.told[j].part, bullets.told[j].part);
        EXPECT_NEAR(ours.told[j].fraction, bullets.told[j].fraction, 1e-5);
        if (ours.told[j].triangle != bullets.told[j].triangle) continue;  // at an edge
        EXPECT_LT((ours.told[j].normal - bullets.told[j].normal).length(), 1e-3);
        ++hits;
      }
    }
  }
  EXPECT_GT(hits, 500);
}

TEST_P(RayTests, follow_whatever_the_app_does) {
  btSoftBody& lower = add_sheet(0);
  btSoftBody& upper = add_sheet(1);
  using Objects = std::vector<const btCollisionObject*>;
  EXPECT_EQ(objects_below(btScalar(0.11), btScalar(0.07)), (Objects{&upper, &lower}));
  lower.translate(btVector3(0, 2, 0));
  EXPECT_EQ(objects_below(btScalar(0.11), btScalar(0.07)), (Objects{&lower, &upper}));
  EXPECT_NEAR(told(kHigh, kLow).told[0].fraction, 0.4, 1e-6);
  simulation.step();
  EXPECT_EQ(objects_below(btScalar(0.11), btScalar(0.07)), (Objects{&lower, &upper}));
  // Nodes move without a call of forget_ray_positions().
  for (int i = 0; i < upper.m_nodes.size(); ++i) upper.m_nodes[i].m_x.setY(btScalar(1.5));
  EXPECT_NEAR(told(kHigh, kLow).told[1].fraction, 0.425, 1e-6);
  // Faces go.
  while (lower.m_faces.size() > 0) lower.m_faces.pop_back();
  EXPECT_EQ(objects_below(btScalar(0.11), btScalar(0.07)), (Objects{&upper}));
  const std::unique_ptr<btSoftBody> removed = simulation.remove(upper);
  EXPECT_TRUE(objects_below(btScalar(0.11), btScalar(0.07)).empty());
  btSoftBody& third = add_sheet(3);
  EXPECT_EQ(objects_below(btScalar(0.11), btScalar(0.07)), (Objects{&third}));
}

TEST_P(RayTests, follow_nodes_that_the_app_moves_by_hand_where_it_says_so) {
  btSoftBody& sheet = add_sheet(0);
  simulation.step();
  const btVector3 from(-3, btScalar(0.02), btScalar(0.01));
  const btVector3 to(3, btScalar(0.02), btScalar(0.01));
  EXPECT_FALSE(told(from, to).hasHit());
  sheet.m_nodes[sheet.m_nodes.size() / 2].m_x.setY(btScalar(0.1));
  simulation.detection().forget_ray_positions();
  EXPECT_TRUE(told(from, to).hasHit());
}

TEST_P(RayTests, never_tell_a_face_that_has_left) {
  btSoftBody& sheet = add_sheet(0);
  simulation.step();
  EXPECT_TRUE(told(kHigh, kLow).hasHit());
  for (int i = 0; i < sheet.m_nodes.size(); ++i) sheet.m_nodes[i].m_x += btVector3(2, 0, 0);
  EXPECT_FALSE(told(kHigh, kLow).hasHit());
}

TEST_P(RayTests, tell_where_nodes_are_at_any_time_of_a_step) {
  SheetOptions options;
  options.height = 1;
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  int rays = 0;
  const auto compare = [&] {
    const RayListener listener = told(kHigh, kLow);
    ASSERT_TRUE(listener.hasHit());
    EXPECT_NEAR(listener.told[0].fraction, (10 - sheet.m_nodes[0].m_x.y()) / 20, 1e-6);
    ++rays;
  };
  struct Casting final : btActionInterface {
    std::function<void()> cast;
    void updateAction(btCollisionWorld* /*world*/, btScalar /*time_step*/) override { cast(); }
    void debugDraw(btIDebugDraw* /*drawer*/) override {}
  } action;
  action.cast = compare;
  simulation.world().setInternalTickCallback(
      [](btDynamicsWorld* world, btScalar) { static_cast<Casting*>(world->getWorldUserInfo())->cast(); }, &action,
      /*isPreTick=*/true);
  simulation.world().addAction(&action);
  for (int step = 0; step < 4; ++step) {
    simulation.step();
    compare();
    compare();
  }
  simulation.world().removeAction(&action);
  EXPECT_GE(rays, 16);
}

TEST_P(RayTests, leave_out_faces_without_a_place) {
  btSoftBody& sheet = add_sheet(0);
  simulation.step();
  const btScalar nowhere = std::numeric_limits<btScalar>::quiet_NaN();
  sheet.m_nodes[0].m_x.setValue(nowhere, nowhere, nowhere);
  simulation.detection().forget_ray_positions();
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(told(kHigh, kLow).hasHit());
  const btVector3 corner(btScalar(-0.49), 0, btScalar(-0.49));
  EXPECT_FALSE(told(corner + btVector3(0, 1, 0), corner - btVector3(0, 1, 0)).hasHit());
}

TEST_P(RayTests, tell_many_threads_the_same) {
  add_sheet(0);
  add_sheet(1);
  simulation.step();
  std::vector<std::size_t> hits(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t& count : hits) {
    threads.emplace_back([this, &count] {
      for (int i = 0; i < 10000; ++i) {
        const btVector3 x(btScalar(0.00011) * btScalar(i) - btScalar(0.6), 0, btScalar(0.07));
        count += told(x + btVector3(0, 10, 0), x - btVector3(0, 10, 0)).told.size();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(hits[0], 10000U);
  EXPECT_EQ(hits, std::vector<std::size_t>(hits.size(), hits[0]));
}

TEST_P(RayTests, ask_the_callback_about_every_body) {
  add_sheet(0);
  RayListener listener;
  listener.m_collisionFilterMask = btBroadphaseProxy::StaticFilter;
  simulation.world().rayTest(kHigh, kLow, listener);
  EXPECT_FALSE(listener.hasHit());
  listener.m_collisionFilterMask = btBroadphaseProxy::AllFilter;
  simulation.world().rayTest(kHigh, kLow, listener);
  EXPECT_TRUE(listener.hasHit());
}

TEST_P(RayTests, go_nowhere_without_a_length) {
  add_sheet(0);
  EXPECT_FALSE(told(btVector3(0, 0, 0), btVector3(0, 0, 0)).hasHit());
  btCollisionWorld::ClosestRayResultCallback closest(kHigh, kLow);
  simulation.world().rayTest(kHigh, kLow, closest);
  ASSERT_TRUE(closest.hasHit());
  EXPECT_NEAR(closest.m_hitPointWorld.y(), 0, 1e-5);
  EXPECT_NEAR(closest.m_hitNormalWorld.y(), 1, 1e-5);
}

TEST_P(RayTests, go_on_as_bullets_where_memory_runs_out) {
  add_sheet(0);
  std::vector<std::string> warnings;
  bullet::Settings settings = cpu_settings();
  settings.log = [&](LogLevel level, std::string_view text) {
    if (level == LogLevel::warning) warnings.emplace_back(text);
  };
  simulation.detection().set_settings(settings);
  EXPECT_TRUE(told(kHigh, kLow).hasHit());
  warnings.clear();
  for_every_allocation([&](std::uint64_t n) {
    simulation.detection().set_settings(settings);
    RayListener listener;
    listener.told.reserve(4);
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      try {
        simulation.world().rayTest(kHigh, kLow, listener);
      } catch (const std::bad_alloc&) {
        listener.told.push_back({});  // from softcd's list of objects or from Bullet; nothing is left behind
      }
      has_failed = failing.has_failed();
    }
    EXPECT_EQ(listener.told.size(), 1U) << "allocation " << n;
    EXPECT_EQ(told(kHigh, kLow).told.size(), 1U);
    return has_failed && !HasFailure();
  });
}

INSTANTIATE_TEST_SUITE_P(Worlds, RayTests, testing::Values(World::one_line, World::multi_body, World::deformable),
                         world_name);

/// A tetrahedron without faces.
TEST(RayTestsOfTetrahedra, tell_their_index_in_classic_worlds) {
  AnySimulation simulation(World::one_line, cpu_settings());
  const btVector3 x[4] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const btScalar masses[4] = {1, 1, 1, 1};
  auto body = std::make_unique<btSoftBody>(&simulation.world_info(), 4, x, masses);
  body->appendTetra(0, 1, 2, 3);
  const btSoftBody& tetrahedron = simulation.add(std::move(body));
  for (const bool is_bullets : {false, true}) {
    RayListener listener;
    const btVector3 from(btScalar(0.1), 5, btScalar(0.2));
    const btVector3 to(btScalar(0.1), -5, btScalar(0.2));
    if (is_bullets) {
      bullets_ray_test(simulation.world(), from, to, listener);
    } else {
      simulation.world().rayTest(from, to, listener);
    }
    ASSERT_EQ(listener.told.size(), 1U);
    EXPECT_EQ(listener.told[0].object, &tetrahedron);
    EXPECT_EQ(listener.told[0].triangle, 0);
    EXPECT_NEAR(listener.told[0].normal.y(), 1, 1e-6);
    EXPECT_NEAR(listener.told[0].fraction, 0.43, 1e-6);
  }
}

}  // namespace
}  // namespace softcd::test
