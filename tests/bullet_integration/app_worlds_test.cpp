// Everything that an app can do with its world between steps and around it.

#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "BulletSoftBody/btSoftMultiBodyDynamicsWorld.h"
#include "BulletSoftBody/btSoftRigidDynamicsWorld.h"
#include "small_scenes.hpp"
#include "world_outputs.hpp"

namespace softcd::test {
namespace {

using demo::PlugIn;
using demo::Simulation;
using Flags = btSoftBody::fCollision;

class AppWorlds : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, AppWorlds, testing::ValuesIn(kPlugIns), plug_in_name);

TEST_P(AppWorlds, four_substeps_are_four_steps) {
  constexpr btScalar kSubstep = btScalar(1) / 240;
  const auto run = [](PlugIn plug_in, auto step) {
    ClothOnSheet scene(plug_in);
    for (int i = 0; i < 20; ++i) step(scene.simulation);
    EXPECT_GT(mean_height(*scene.cloth), 0.05) << "it fell through";
    return std::make_pair(coordinates_of(*scene.cloth), mean_height(*scene.cloth));
  };
  const auto substeps = [](Simulation& simulation) {
    EXPECT_EQ(simulation.world().stepSimulation(4 * kSubstep, /*maxSubSteps=*/4, kSubstep), 4);
  };
  const auto steps = [](Simulation& simulation) {
    for (int i = 0; i < 4; ++i) simulation.step(kSubstep);
  };
  EXPECT_EQ(run(GetParam(), substeps).first, run(GetParam(), steps).first);
  EXPECT_NEAR(double(run(GetParam(), substeps).second), double(run(PlugIn::none, substeps).second), 0.005);
}

/// Lets other threads run in the middle of a collision detection.
void yield_and_process(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  std::this_thread::yield();
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
}

/// Returns the node positions of a stack of small sheets after some steps.
std::vector<btScalar> end_of_stack(PlugIn plug_in, int steps) {
  Simulation simulation(plug_in, cpu_settings(Detection::ccd));
  simulation.dispatcher().setNearCallback(yield_and_process);
  SheetOptions options;
  options.nodes_per_side = 4;
  options.margin = btScalar(0.02);
  std::vector<btSoftBody*> sheets;
  for (int layer = 0; layer < 8; ++layer) {
    options.fixed = layer == 0;
    options.height = btScalar(layer) * btScalar(0.05);
    sheets.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
  }
  for (int i = 0; i < steps; ++i) simulation.step(kStep);
  std::vector<btScalar> coordinates;
  for (const btSoftBody* sheet : sheets) append(coordinates, coordinates_of(*sheet));
  return coordinates;
}

TEST_P(AppWorlds, one_world_per_thread_gives_the_same_as_alone) {
  std::array<std::vector<btScalar>, 4> results;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < results.size(); ++t) {
    threads.emplace_back([&, t] { results[t] = end_of_stack(GetParam(), 60 + static_cast<int>(t)); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t t = 0; t < results.size(); ++t) {
    EXPECT_EQ(results[t], end_of_stack(GetParam(), 60 + static_cast<int>(t)));
  }
}

/// The state of a body that an app saves.
struct SavedNodes {
  std::vector<btVector3> positions, previous, velocities;

  explicit SavedNodes(const btSoftBody& body) {
    for (int i = 0; i < body.m_nodes.size(); ++i) {
      positions.push_back(body.m_nodes[i].m_x);
      previous.push_back(body.m_nodes[i].m_q);
      velocities.push_back(body.m_nodes[i].m_v);
    }
  }
  void restore(btSoftBody& body) const {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      btSoftBody::Node& node = body.m_nodes[static_cast<int>(i)];
      node.m_x = positions[i];
      node.m_q = previous[i];
      node.m_v = velocities[i];
    }
  }
};

TEST_P(AppWorlds, a_restored_state_goes_on_as_before) {
  ClothOnSheet scene(GetParam());
  scene.run(10);
  const SavedNodes saved(*scene.cloth);
  scene.run(15);
  const std::vector<btScalar> first = coordinates_of(*scene.cloth);
  EXPECT_GT(scene.cloth->m_scontacts.size(), 0);
  saved.restore(*scene.cloth);
  scene.run(15);
  EXPECT_EQ(coordinates_of(*scene.cloth), first);
  ClothOnSheet elsewhere(GetParam());
  elsewhere.run(1);  // Bullet's first step takes the links' lengths for their rest lengths
  saved.restore(*elsewhere.cloth);
  elsewhere.run(15);
  EXPECT_EQ(coordinates_of(*elsewhere.cloth), first);
}

/// A bit of everything that Bullet draws and saves: sheets in contact with each other and a box, clusters, joints.
struct Collection {
  TwoSheets sheets;
  ClusteredBalls clustered;

  explicit Collection(PlugIn plug_in) : sheets(plug_in), clustered(sheets.simulation(), Flags::CL_SS | Flags::CL_RS) {
    sheets.add();
    sheets.simulation().add_static_box(btVector3(1, 1, 1), btVector3(0, -1, 0));
    sheets.lower().appendNote("note", btVector3(0, 0, 0), &sheets.lower().m_nodes[0]);
    sheets.upper().setMass(0, 0);
    btSoftBody::LJoint::Specs joint;
    joint.position = btVector3(btScalar(5.45), 0, 0);
    clustered.balls[0]->appendLinearJoint(joint, clustered.balls[1]);
    for (int i = 0; i < 2; ++i) sheets.step();
  }
  btDiscreteDynamicsWorld& world() { return sheets.simulation().world(); }
};

TEST_P(AppWorlds, are_saved_as_bullets_are) {
  Collection ours(GetParam());
  Collection bullets(PlugIn::none);
  const SavedWorld saved = save(ours.world());
  EXPECT_EQ(saved.chunks, save(bullets.world()).chunks);
  const int clusters = Flags::CL_SS | Flags::CL_RS;
  const int sheets = Flags::SDF_RS | Flags::VF_SS;
  EXPECT_EQ(saved.collision_flags, (std::vector<int>{clusters, clusters, sheets, sheets}));
}

int lines_drawn_of(btDiscreteDynamicsWorld& world, int draw_flags) {
  if (auto* soft_rigid = dynamic_cast<btSoftRigidDynamicsWorld*>(&world)) soft_rigid->setDrawFlags(draw_flags);
  if (auto* multi_body = dynamic_cast<btSoftMultiBodyDynamicsWorld*>(&world)) multi_body->setDrawFlags(draw_flags);
  return lines_drawn(world);
}

// softcd builds no face trees of Bullet's.
TEST_P(AppWorlds, are_drawn_as_bullets_are_but_for_face_trees) {
  Collection ours(GetParam());
  Collection bullets(PlugIn::none);
  const int nothing = lines_drawn_of(ours.world(), 0);
  for (int flag = fDrawFlags::Nodes; flag <= fDrawFlags::Joints; flag *= 2) {
    const int lines = lines_drawn_of(ours.world(), flag);
    if (flag == fDrawFlags::FaceTree) {
      EXPECT_EQ(lines, nothing);
      continue;
    }
    EXPECT_EQ(lines, lines_drawn_of(bullets.world(), flag)) << "flag " << flag;
    if (flag != fDrawFlags::Tetras) {
      EXPECT_GT(lines, nothing) << "flag " << flag;
    }
  }
  EXPECT_GT(lines_drawn_of(ours.world(), -1), 0);
}

/// A crate that rests on the box of a Collection, with any solver of the world.
class Crate {
 public:
  explicit Crate(btDiscreteDynamicsWorld& world) : world_(world), body_(1, nullptr, &shape_, btVector3(1, 1, 1)) {
    body_.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.1), btScalar(0.9))));
    body_.setLinearFactor(btVector3(0, 0, 0));
    body_.setAngularFactor(btVector3(0, 0, 0));
    world_.addRigidBody(&body_);
  }
  ~Crate() { world_.removeRigidBody(&body_); }
  Crate(const Crate&) = delete;
  Crate& operator=(const Crate&) = delete;

  btRigidBody& body() { return body_; }

 private:
  btDiscreteDynamicsWorld& world_;
  btBoxShape shape_{btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1))};
  btRigidBody body_;
};

struct PointCounter : btCollisionWorld::ContactResultCallback {
  int points = 0;
  btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*,
                           int, int) override {
    ++points;
    return 0;
  }
};

/// Counts the points that contact tests of all pairs of objects report, and those of a ray from above each of them.
int points_of_tests(btDiscreteDynamicsWorld& world) {
  PointCounter counter;
  btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int a = 0; a < objects.size(); ++a) {
    world.contactTest(objects[a], counter);
    const btVector3 above(objects[a]->getWorldTransform().getOrigin() + btVector3(btScalar(0.2), 3, btScalar(0.2)));
    btCollisionWorld::ClosestRayResultCallback ray(above, above - btVector3(0, 6, 0));
    world.rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
    counter.points += ray.hasHit();
    for (int b = 0; b < objects.size(); ++b) {
      if (a != b) world.contactPairTest(objects[a], objects[b], counter);
    }
  }
  world.performDiscreteCollisionDetection();
  return counter.points;
}

TEST_P(AppWorlds, tests_between_steps_report_what_bullets_do_and_disturb_nothing) {
  const auto run = [](PlugIn plug_in, int& points) {
    Collection collection(plug_in);
    const Crate crate(collection.world());
    for (btSoftBody* body : {&collection.sheets.lower(), &collection.sheets.upper()}) body->m_cfg.piterations = 2;
    int contacts = 0;
    for (int step = 0; step < 5; ++step) {
      if (points >= 0) points += points_of_tests(collection.world());
      contacts += collection.sheets.step();
    }
    EXPECT_GT(contacts, 0);
    return coordinates_of(collection.sheets.upper());
  };
  int without = -1;
  int ours = 0;
  int bullets = 0;
  EXPECT_EQ(run(GetParam(), ours), run(GetParam(), without));
  run(PlugIn::none, bullets);
  EXPECT_GT(ours, 0);
  EXPECT_EQ(ours, bullets);
}

int added_contacts = 0;

class ContactCallback {
 public:
  ContactCallback() {
    added_contacts = 0;
    gContactAddedCallback = [](btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                               const btCollisionObjectWrapper*, int, int) {
      ++added_contacts;
      return false;
    };
  }
  ~ContactCallback() { gContactAddedCallback = nullptr; }
  ContactCallback(const ContactCallback&) = delete;
  ContactCallback& operator=(const ContactCallback&) = delete;
};

TEST_P(AppWorlds, rigid_pairs_still_call_the_contact_callback) {
  const auto calls = [](PlugIn plug_in) {
    Collection collection(plug_in);
    Crate crate(collection.world());
    crate.body().setCollisionFlags(crate.body().getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    const ContactCallback callback;
    for (int step = 0; step < 5; ++step) EXPECT_GT(collection.sheets.step(), 0);
    return added_contacts;
  };
  EXPECT_GT(calls(GetParam()), 0);
  EXPECT_EQ(calls(GetParam()), calls(PlugIn::none));
}

}  // namespace
}  // namespace softcd::test
