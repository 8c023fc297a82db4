// State of Bullet and the app that softcd replaces, and restores.

#include <gtest/gtest.h>

#include <functional>

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h"
#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "any_simulation.hpp"
#include "deformable_app_support.hpp"
#include "softcd/bullet/dispatcher.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::test {
namespace {

using Flags = btSoftBody::fCollision;

constexpr int kSoftProxy = SOFTBODY_SHAPE_PROXYTYPE;
constexpr int kMesh = TRIANGLE_MESH_SHAPE_PROXYTYPE;

const btCollisionAlgorithmCreateFunc* registered(btCollisionDispatcher& dispatcher, int type0, int type1) {
  struct Table : btCollisionDispatcher {
    static const btCollisionAlgorithmCreateFunc* entry(btCollisionDispatcher& from, int a, int b) {
      return (from.*&Table::m_doubleDispatchContactPoints)[a][b];
    }
  };
  return Table::entry(dispatcher, type0, type1);
}

/// An app's own algorithm, which does nothing but count.
struct CountingAlgorithm : btCollisionAlgorithm {
  int& calls;
  CountingAlgorithm(const btCollisionAlgorithmConstructionInfo& info, int& counter)
      : btCollisionAlgorithm(info), calls(counter) {}
  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*, const btDispatcherInfo&,
                        btManifoldResult*) override {
    ++calls;
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray&) override {}
};

struct CountingCreateFunc : btCollisionAlgorithmCreateFunc {
  int calls = 0;
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper*,
                                                 const btCollisionObjectWrapper*) override {
    return new (btAlignedAlloc(sizeof(CountingAlgorithm), 16)) CountingAlgorithm(info, calls);
  }
};

/// A sheet at the margin above a mesh of one triangle.
struct SheetOnMesh {
  btTriangleMesh triangles;
  btSoftBody* sheet;

  explicit SheetOnMesh(AnySimulation& simulation) {
    triangles.addTriangle(btVector3(-3, 0, -3), btVector3(0, 0, 6), btVector3(3, 0, -3));
    simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles, true), btVector3(0, 0, 0));
    SheetOptions options;
    options.margin = btScalar(0.05);
    options.height = btScalar(0.04);
    sheet = &simulation.add(make_sheet(simulation.world_info(), options));
  }
  int count_contacts() const { return sheet->m_rcontacts.size() + sheet->m_nodeRigidContacts.size(); }
};

class Algorithms : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, Algorithms, kWorlds, world_name);

TEST_P(Algorithms, of_an_app_stay_registered) {
  CountingCreateFunc soft_soft, soft_mesh;
  AnySimulation simulation(GetParam(), cpu_settings(Detection::ccd));
  btCollisionDispatcher& dispatcher = simulation.dispatcher();
  dispatcher.registerCollisionCreateFunc(kSoftProxy, kSoftProxy, &soft_soft);
  for (const auto& [a, b] : {std::pair{kSoftProxy, kMesh}, std::pair{kMesh, kSoftProxy}}) {
    dispatcher.registerCollisionCreateFunc(a, b, &soft_mesh);
  }
  const SheetOnMesh scene(simulation);
  simulation.step(kStep);
  EXPECT_EQ(soft_mesh.calls, 0) << "softcd takes the pair";
  EXPECT_GT(scene.count_contacts(), 0);
  EXPECT_EQ(registered(dispatcher, kSoftProxy, kSoftProxy), &soft_soft);
  EXPECT_EQ(registered(dispatcher, kSoftProxy, kMesh), &soft_mesh);
  EXPECT_EQ(registered(dispatcher, kMesh, kSoftProxy), &soft_mesh);
  scene.sheet->m_cfg.collisions = (scene.sheet->m_cfg.collisions & ~Flags::RVSmask) | Flags::CL_RS;
  simulation.step(kStep);
  EXPECT_EQ(soft_mesh.calls, 1) << "the pair is the app's";
}

TEST(GivingBack, algorithms_that_come_between_two_steps_stay_and_pairs_stay_softcds) {
  AnySimulation simulation(World::one_line, cpu_settings());
  const SheetOnMesh scene(simulation);
  simulation.step(kStep);
  btCollisionDispatcher& dispatcher = simulation.dispatcher();
  btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
  const auto* gimpact = registered(dispatcher, kSoftProxy, GIMPACT_SHAPE_PROXYTYPE);
  simulation.step(kStep);
  EXPECT_EQ(registered(dispatcher, kSoftProxy, GIMPACT_SHAPE_PROXYTYPE), gimpact);
  EXPECT_GT(simulation.detection().rigid_mesh_report().statistics().vt_contacts, 0U);
}

/// Two sheets within each other's reach, in any world.
struct SheetsOfBullet {
  btSoftBodyWorldInfo info;
  std::unique_ptr<btSoftBody> lower, upper;

  SheetsOfBullet() {
    info.m_gravity.setZero();
    SheetOptions options;
    options.margin = btScalar(0.02);
    lower = make_sheet(info, options);
    options.height = btScalar(0.03);
    upper = make_sheet(info, options);
  }
  template <class World>
  void add_to(World& world) {
    info.m_broadphase = world.getBroadphase();
    info.m_dispatcher = world.getDispatcher();
    for (btSoftBody* body : {lower.get(), upper.get()}) world.addSoftBody(body);
  }
  template <class World>
  void remove_from(World& world) {
    for (btSoftBody* body : {lower.get(), upper.get()}) world.removeSoftBody(body);
  }
  int count_contacts() const { return lower->m_scontacts.size() + upper->m_scontacts.size(); }
};

class GivenBack : public testing::Test {
 protected:
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btSequentialImpulseConstraintSolver solver;
  btCollisionDispatcher plain_dispatcher{&configuration};
  btDbvtBroadphase plain_broadphase;
  SheetsOfBullet sheets;

  /// How many contacts a step of Bullet's own has.
  int bullets_contacts() {
    btSoftRigidDynamicsWorld world(&plain_dispatcher, &plain_broadphase, &solver, &configuration);
    sheets.add_to(world);
    world.stepSimulation(kStep, 0);
    sheets.remove_from(world);
    return sheets.count_contacts();
  }
};

TEST_F(GivenBack, two_worlds_on_a_dispatcher_disturb_no_algorithm) {
  const auto* soft_soft = registered(plain_dispatcher, kSoftProxy, kSoftProxy);
  const auto* soft_mesh = registered(plain_dispatcher, kSoftProxy, kMesh);
  {
    btDbvtBroadphase broadphase;
    bullet::SoftRigidDynamicsWorld first(&plain_dispatcher, &broadphase, &solver, &configuration, nullptr,
                                         cpu_settings());
    {
      btDbvtBroadphase other_broadphase;
      bullet::SoftRigidDynamicsWorld second(&plain_dispatcher, &other_broadphase, &solver, &configuration, nullptr,
                                            cpu_settings());
      for (btSoftRigidDynamicsWorld* world : {&first, &second, &first}) world->stepSimulation(kStep, 0);
    }
    sheets.add_to(first);
    first.stepSimulation(kStep, 0);
    EXPECT_GT(sheets.count_contacts(), 0);
    sheets.remove_from(first);
  }
  EXPECT_EQ(registered(plain_dispatcher, kSoftProxy, kSoftProxy), soft_soft);
  EXPECT_EQ(registered(plain_dispatcher, kSoftProxy, kMesh), soft_mesh);
}

TEST_F(GivenBack, bodies_of_a_one_line_world_that_goes_collide_in_bullets_world) {
  {
    btDbvtBroadphase broadphase;
    bullet::SoftRigidDynamicsWorld world(&plain_dispatcher, &broadphase, &solver, &configuration, nullptr,
                                         cpu_settings());
    sheets.add_to(world);
    world.stepSimulation(kStep, 0);
    EXPECT_GT(sheets.count_contacts(), 0);
  }
  EXPECT_GT(bullets_contacts(), 0);
}

TEST_F(GivenBack, bodies_removed_from_a_softcd_world_collide_in_bullets_world_with_a_new_face_tree) {
  btDbvtBroadphase broadphase;
  bullet::SoftRigidDynamicsWorld world(&plain_dispatcher, &broadphase, &solver, &configuration, nullptr,
                                       cpu_settings());
  sheets.add_to(world);
  world.stepSimulation(kStep, 0);
  sheets.remove_from(world);
  for (btSoftBody* body : {sheets.lower.get(), sheets.upper.get()}) bullet::give_face_tree(*body);
  EXPECT_GT(bullets_contacts(), 0);
}

TEST_F(GivenBack, a_broadphase_whose_dispatcher_is_gone_hides_nothing) {
  bullet::Broadphase broadphase(plain_broadphase);
  {
    const bullet::Dispatcher dispatcher(&configuration, broadphase, cpu_settings());
    btSoftRigidDynamicsWorld world(&plain_dispatcher, &broadphase, &solver, &configuration);
    sheets.add_to(world);
    EXPECT_EQ(sheets.lower->m_cfg.collisions & Flags::VF_SS, 0);
    sheets.remove_from(world);
  }
  btSoftRigidDynamicsWorld world(&plain_dispatcher, &broadphase, &solver, &configuration);
  sheets.add_to(world);
  EXPECT_NE(sheets.lower->m_cfg.collisions & Flags::VF_SS, 0);
  for (btSoftBody* body : {sheets.lower.get(), sheets.upper.get()}) bullet::give_face_tree(*body);
  world.stepSimulation(kStep, 0);
  EXPECT_GT(sheets.count_contacts(), 0);
  sheets.remove_from(world);
}

TEST_F(GivenBack, a_broadphase_may_go_before_its_dispatcher) {
  auto broadphase = std::make_unique<bullet::Broadphase>(plain_broadphase);
  auto dispatcher = std::make_unique<bullet::Dispatcher>(&configuration, *broadphase, cpu_settings());
  broadphase.reset();
  dispatcher.reset();
}

TEST(GivingBack, bodies_of_a_deformable_world_keep_what_says_whether_bullet_tests_them) {
  TwoHeldSheets sheets(cpu_settings());
  sheets.step();
  const int once = count_contacts(sheets.bodies());
  const int flags = sheets.lower.m_cfg.collisions;
  for (btSoftBody* body : {&sheets.lower, &sheets.upper}) {
    body->m_softSoftCollision = true;
    bullet::give_face_tree(*body);  // with which Bullet would find them as well
  }
  sheets.upper.m_softSoftCollision = false;
  for (int i = 0; i < 2; ++i) {
    sheets.step();
    EXPECT_EQ(count_contacts(sheets.bodies()), once);
    EXPECT_TRUE(sheets.lower.m_softSoftCollision);
    EXPECT_EQ(sheets.upper.m_softSoftCollision, i > 0);
    EXPECT_EQ(sheets.lower.m_cfg.collisions, flags);
    sheets.upper.m_softSoftCollision = true;
  }
}

/// Bullet's own contacts of two sheets that were in a world with these settings, which is gone.
int contacts_in_bullets_world_after(const MaybeSettings& settings) {
  btSoftBodyWorldInfo info;  // outlives both worlds
  info.m_gravity.setZero();
  const auto make_world = [&](const MaybeSettings& made_with) {
    auto world = std::make_unique<OwnWorld>();
    world->make(made_with);
    info.m_broadphase = world->broadphase.get();
    info.m_dispatcher = world->dispatcher.get();
    return world;
  };
  auto first = make_world(settings);
  for (const btScalar height : {btScalar(0), btScalar(0.03)}) first->add(make_small_sheet(info, height));
  first->world->stepSimulation(kShortStep, 0);
  std::vector<std::unique_ptr<btSoftBody>> bodies = std::exchange(first->bodies, {});
  first.reset();
  const auto second = make_world(std::nullopt);
  for (auto& body : bodies) second->add(std::move(body));
  second->world->stepSimulation(kShortStep, 0);
  return count_contacts(second->world->getSoftBodyArray());
}

TEST(GivingBack, bodies_of_a_deformable_world_that_goes_collide_in_bullets_world) {
  const int expected = contacts_in_bullets_world_after(std::nullopt);
  EXPECT_GT(expected, 0);
  EXPECT_EQ(contacts_in_bullets_world_after(cpu_settings()), expected);
}

/// A sheet comes upon a mesh while `between` is called, after a step of softcd's, and has another step there. Returns
/// how many contacts softcd finds then.
std::uint64_t contacts_with_mesh_after(const std::function<void(AnySimulation&)>& between) {
  AnySimulation simulation(World::deformable, cpu_settings());
  const SheetOnMesh scene(simulation);
  scene.sheet->translate(btVector3(0, 5, 0));
  simulation.step(kShortStep);
  scene.sheet->translate(btVector3(0, -5, 0));
  between(simulation);
  simulation.step(kShortStep);
  return simulation.detection().rigid_mesh_report().statistics().vt_contacts;
}

TEST(GivingBack, rigid_meshes_are_bullets_when_turned_off_and_softcds_when_turned_on_again) {
  const auto turn_off_and_on = [](AnySimulation& simulation) {
    bullet::Settings settings = cpu_settings();
    for (const bool rigid_meshes : {false, true}) {
      settings.rigid_meshes = rigid_meshes;
      simulation.detection().set_settings(settings);
      if (!rigid_meshes) simulation.step(kShortStep);
    }
    EXPECT_EQ(simulation.detection().rigid_mesh_report().statistics().vt_contacts, 0U);
  };
  EXPECT_GT(contacts_with_mesh_after(turn_off_and_on), 0U);
}

TEST(GivingBack, pairs_that_an_app_has_bullet_process_between_steps_stay_softcds) {
  const auto process = [](AnySimulation& simulation) { simulation.world().performDiscreteCollisionDetection(); };
  EXPECT_GT(contacts_with_mesh_after(process), 0U);
}

}  // namespace
}  // namespace softcd::test
