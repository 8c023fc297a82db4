// Everything that an app can do with a deformable world and its solvers, compared with Bullet's own result.

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "LinearMath/btThreads.h"
#include "deformable_app_support.hpp"
#include "softcd/bullet/dispatcher.hpp"

namespace softcd::test {
namespace {

using demo::DeformableSimulation;
using Flags = btSoftBody::fCollision;

/// A cloth that falls the last bit onto a held sheet.
struct FallingCloth {
  DeformableSimulation simulation;
  btSoftBody& sheet;
  btSoftBody& cloth;

  explicit FallingCloth(const MaybeSettings& settings)
      : simulation(settings),
        sheet(simulation.add(make_small_sheet(simulation.world_info(), 0, /*fixed=*/true))),
        cloth(simulation.add(make_small_sheet(simulation.world_info(), btScalar(0.045)))) {}
  btDeformableMultiBodyDynamicsWorld& world() { return simulation.world(); }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) simulation.step(kShortStep);
  }
};

TEST(DeformableAppWorlds, steps_without_bodies_or_with_a_body_without_nodes_are_harmless) {
  const auto run = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    Steps steps = {sheets.step()};
    btSoftBody& lower = sheets.add(0);
    sheets.add(std::make_unique<btSoftBody>(&sheets.simulation().world_info(), 0, nullptr, nullptr));
    btSoftBody& upper = sheets.add(btScalar(0.03));
    steps.push_back(sheets.step());
    sheets.remove(lower);
    sheets.remove(upper);
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {false, true, false});
}

struct Calls {
  int before = 0, during = 0, solver = 0;
  btScalar seconds = 0, time = 0;
};
Calls* calls = nullptr;

TEST(DeformableAppWorlds, substeps_call_back_as_often_as_bullets) {
  const auto run = [](const MaybeSettings& settings) {
    Calls counted;
    calls = &counted;
    FallingCloth scene(settings);
    scene.world().setInternalTickCallback(
        [](btDynamicsWorld*, btScalar seconds) {
          ++calls->before;
          calls->seconds += seconds;
        },
        nullptr, /*isPreTick=*/true);
    scene.world().setInternalTickCallback([](btDynamicsWorld*, btScalar) { ++calls->during; });
    scene.world().setSolverCallback([](btScalar time, btDeformableMultiBodyDynamicsWorld*) {
      ++calls->solver;
      calls->time = time;
    });
    for (int frame = 0; frame < 15; ++frame) {
      EXPECT_EQ(scene.world().stepSimulation(4 * kShortStep + btScalar(1e-6), /*maxSubSteps=*/4, kShortStep), 4);
    }
    calls = nullptr;
    EXPECT_GT(count_contacts(scene.world().getSoftBodyArray()), 0);
    return std::pair(counted, mean_height(scene.cloth));
  };
  const auto [ours, height] = run(cpu_settings());
  const auto [bullets, bullets_height] = run(std::nullopt);
  EXPECT_EQ(ours.before, 60);
  EXPECT_EQ(ours.before, bullets.before);
  EXPECT_EQ(ours.during, bullets.during);
  EXPECT_EQ(ours.solver, bullets.solver);
  EXPECT_EQ(ours.solver, 120);
  EXPECT_EQ(ours.seconds, bullets.seconds);
  EXPECT_EQ(ours.time, bullets.time);
  EXPECT_NEAR(double(height), double(bullets_height), 0.005);
}

/// The sheets of a test, for callbacks.
TwoHeldSheets* held = nullptr;

TEST(DeformableAppWorlds, what_callbacks_change_counts_in_the_same_step) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    held = &sheets;
    btDynamicsWorld& world = sheets.simulation().world();
    Steps steps = {sheets.step()};
    const auto before_step = [](btDynamicsWorld*, btScalar) {
      held->upper.appendNode(btVector3(0, btScalar(0.03), btScalar(0.1)), 1);
      held->upper.appendFace(0, 1, held->upper.m_nodes.size() - 1);
      held->upper.appendLink(0, held->upper.m_nodes.size() - 1);  // Bullet hangs on a node that has none
      held->add(btScalar(0.06));
    };
    world.setInternalTickCallback(before_step, nullptr, /*isPreTick=*/true);
    steps.push_back(sheets.step());
    EXPECT_GT(steps[1].size(), 2 * steps[0].size());
    world.setInternalTickCallback(nullptr, nullptr, /*isPreTick=*/true);
    world.setInternalTickCallback([](btDynamicsWorld*, btScalar) { held->upper.m_cfg.collisions = Flags::SDF_RD; });
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {true, true, false});
}

// Not implicit without projection: Bullet then writes behind its arrays as soon as a node is held.
TEST(DeformableAppWorlds, solvers_settings_lead_where_they_do_with_bullet) {
  for (const int options : {0, 2, 3, 7}) {
    SCOPED_TRACE(options);
    expect_as_bullets(
        [&](const MaybeSettings& settings) {
          FallingCloth scene(settings);
          scene.world().setImplicit((options & 1) != 0);
          scene.world().setUseProjection((options & 2) != 0);
          scene.world().setLineSearch((options & 4) != 0);
          scene.simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), btVector3(0, btScalar(-1.2), 0));
          scene.run(60);
          EXPECT_GT(mean_height(scene.cloth), btScalar(0.01));
          return double(mean_height(scene.cloth));
        },
        0.01);
  }
}

TEST(DeformableAppWorlds, steps_of_changing_length_lead_where_they_do_with_bullet) {
  expect_as_bullets(
      [](const MaybeSettings& settings) {
        FallingCloth scene(settings);
        for (int i = 0; i < 80; ++i) scene.simulation.step(kShortStep * (1 + btScalar(i % 3) / 2));
        EXPECT_GT(mean_height(scene.cloth), btScalar(0.01));
        return double(mean_height(scene.cloth));
      },
      0.01);
}

TEST(DeformableAppWorlds, contacts_are_found_once_where_the_app_asks_bullet_too) {
  TwoHeldSheets sheets(cpu_settings());
  const int once = static_cast<int>(sheets.step().size());
  for (btSoftBody* body : {&sheets.lower, &sheets.upper}) body->m_softSoftCollision = true;
  sheets.step();
  EXPECT_EQ(count_contacts(sheets.bodies()), once);
  EXPECT_TRUE(sheets.lower.m_softSoftCollision) << "the app's own";
}

// Bullet never clears the contacts that the classic worlds' flag adds in this world.
TEST(DeformableAppWorlds, the_classic_worlds_flag_does_not_make_contacts_pile_up) {
  TwoHeldSheets sheets(cpu_settings());
  for (btSoftBody* body : {&sheets.lower, &sheets.upper}) body->m_cfg.collisions = Flags::SDF_RD | Flags::VF_SS;
  for (int step = 0; step < 3; ++step) EXPECT_TRUE(sheets.step().empty());
  EXPECT_EQ(sheets.lower.m_scontacts.size() + sheets.upper.m_scontacts.size(), 0);
}

/// Lets other threads run in the middle of a question to the dispatcher.
void wait_and_process(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  std::this_thread::sleep_for(std::chrono::microseconds(100));
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
}

TEST(DeformableAppWorlds, one_world_per_thread_finds_what_it_finds_alone) {
  const auto first_contacts = [](int index) {
    bullet::Settings settings = cpu_settings(index % 2 == 0 ? Detection::dcd : Detection::ccd);
    settings.filter_deformables = true;
    TwoHeldSheets sheets(settings);
    auto* dispatcher = static_cast<btCollisionDispatcher*>(sheets.simulation().world().getDispatcher());
    dispatcher->setNearCallback(wait_and_process);
    sheets.upper.translate(btVector3(btScalar(0.02) * btScalar(index), 0, 0));
    sheets.hold(sheets.upper);
    Steps steps;
    for (int step = 0; step < 20; ++step) steps.push_back(sheets.step());
    return steps;
  };
  std::array<Steps, 4> results;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] { results[static_cast<std::size_t>(t)] = first_contacts(t); });
  }
  for (std::thread& thread : threads) thread.join();
  for (int t = 0; t < 4; ++t) {
    const Steps& steps = results[static_cast<std::size_t>(t)];
    EXPECT_EQ(steps, first_contacts(t));
    EXPECT_FALSE(steps[0].empty());
    EXPECT_EQ(steps[0], steps[19]);
  }
}

/// Contacts of the first step between two sheets, and of the lower one's nodes with a rigid body.
std::pair<NodeFaceSet, int> first_contacts(OwnWorld& own, btCollisionShape& shape) {
  btRigidBody rigid(0, nullptr, &shape);
  rigid.getWorldTransform().setOrigin(btVector3(0, -1, 0));
  own.world->addRigidBody(&rigid);
  const btSoftBody& lower = own.add(make_small_sheet(own.world->getWorldInfo(), btScalar(0.01)));
  own.add(make_small_sheet(own.world->getWorldInfo(), btScalar(0.04)));
  own.world->stepSimulation(kShortStep, 0);
  own.world->removeRigidBody(&rigid);
  return {contacts_in(own.world->getSoftBodyArray()), lower.m_nodeRigidContacts.size()};
}

void expect_contacts_with_every_dispatcher(btCollisionShape& shape, const std::pair<NodeFaceSet, int>& expected) {
  bullet::Settings settings = cpu_settings();
  settings.filter_deformables = true;  // asks the dispatcher
  EXPECT_GT(expected.second, 0);
  OwnWorld plain;
  plain.make(settings);
  EXPECT_EQ(first_contacts(plain, shape), expected);

  set_task_scheduler();
  OwnWorld threaded;
  threaded.dispatcher = std::make_unique<btCollisionDispatcherMt>(&threaded.configuration);
  threaded.make(settings);
  EXPECT_EQ(first_contacts(threaded, shape), expected);

  OwnWorld both_forms;
  auto broadphase = std::make_unique<bullet::Broadphase>(std::make_unique<btDbvtBroadphase>());
  both_forms.dispatcher = std::make_unique<bullet::Dispatcher>(&both_forms.configuration, *broadphase, settings);
  both_forms.broadphase = std::move(broadphase);
  both_forms.make(settings);
  EXPECT_EQ(first_contacts(both_forms, shape), expected);
}

TEST(DeformableAppWorlds, any_dispatcher_leads_to_the_same_contacts) {
  btBoxShape box(btVector3(1, 1, 1));
  OwnWorld bullets;
  bullets.make(std::nullopt);
  expect_contacts_with_every_dispatcher(box, first_contacts(bullets, box));

  btTriangleMesh triangle;
  triangle.addTriangle(btVector3(-9, 1, -9), btVector3(0, 1, 9), btVector3(9, 1, -9));
  btBvhTriangleMeshShape mesh(&triangle, /*useQuantizedAabbCompression=*/true);
  OwnWorld ours;
  ours.make(cpu_settings());
  expect_contacts_with_every_dispatcher(mesh, first_contacts(ours, mesh));
}

TEST(DeformableAppWorlds, gravity_may_change) {
  expect_as_bullets(
      [](const MaybeSettings& settings) {
        OwnWorld own;
        own.make(settings);
        btSoftBody& lower = own.add(make_small_sheet(own.world->getWorldInfo(), 0));
        own.add(make_small_sheet(own.world->getWorldInfo(), btScalar(0.045), /*fixed=*/true));
        for (int step = 0; step < 48; ++step) {
          if (step == 12) own.gravity.m_gravity = btVector3(0, 30, 0);
          own.world->stepSimulation(kShortStep, 0);
        }
        EXPECT_LT(mean_height(lower), btScalar(0.045)) << "the upper one holds it back";
        return double(mean_height(lower));
      },
      0.01);
}

}  // namespace
}  // namespace softcd::test
