// Bullet's multithreaded dispatcher with more pairs than threads. Where Bullet was built with BT_THREADSAFE it calls
// softcd from all of them: tests/thread_safe_bullet.sh.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "soft_body_support.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::test {
namespace {

constexpr int kPlaces = 16;

/// In each place two sheets touch each other, and the lower one a box and a rigid mesh that reaches through all places.
/// Which thread comes first decides about the order of a body's contacts, and with it about the last digits of where it
/// goes, but not about the contacts of the first step.
class Places {
 public:
  explicit Places(btSoftRigidDynamicsWorld& world) : world_(world) {
    world_.getWorldInfo().m_gravity = world_.getGravity();
    ground_.addTriangle(btVector3(-300, 0, -300), btVector3(0, 0, 600), btVector3(300, 0, -300));
    mesh_ = std::make_unique<btBvhTriangleMeshShape>(&ground_, true);
    add_rigid(*mesh_, btVector3(0, 0, 0));
    SheetOptions options;
    options.nodes_per_side = 5;
    for (int place = 0; place < kPlaces; ++place) {
      const btVector3 at(btScalar(3 * place), 0, 0);
      add_rigid(box_, at + btVector3(btScalar(0.1), btScalar(-0.08), 0));
      for (const btScalar height : {btScalar(0.04), btScalar(0.11)}) {
        options.height = height;
        sheets_.push_back(make_sheet(world_.getWorldInfo(), options));
        sheets_.back()->translate(at);
        world_.addSoftBody(sheets_.back().get());
      }
    }
  }
  ~Places() {
    for (const auto& sheet : sheets_) world_.removeSoftBody(sheet.get());
    for (const auto& body : rigid_bodies_) world_.removeRigidBody(body.get());
  }
  Places(const Places&) = delete;
  Places& operator=(const Places&) = delete;

  btScalar lowest() const {
    btScalar lowest = SIMD_INFINITY;
    for (const auto& sheet : sheets_) lowest = btMin(lowest, lowest_height(*sheet));
    return lowest;
  }

 private:
  void add_rigid(btCollisionShape& shape, const btVector3& center) {
    rigid_bodies_.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, &shape));
    rigid_bodies_.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), center));
    world_.addRigidBody(rigid_bodies_.back().get());
  }

  btSoftRigidDynamicsWorld& world_;
  btTriangleMesh ground_;
  std::unique_ptr<btBvhTriangleMeshShape> mesh_;
  btBoxShape box_{btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2))};
  std::vector<std::unique_ptr<btRigidBody>> rigid_bodies_;
  std::vector<std::unique_ptr<btSoftBody>> sheets_;
};

bullet::Settings all_contacts() {
  bullet::Settings settings = cpu_settings(Detection::ccd);
  settings.edge_contacts = bullet::EdgeContacts::respond;
  settings.convex_shapes = bullet::ConvexShapes::faces_and_edges;
  return settings;
}

/// Contacts of the first step: between soft bodies, with the mesh, with the boxes.
using Counts = std::array<std::uint64_t, 3>;

Counts first_contacts(bullet::SoftRigidDynamicsWorld& world) {
  const Places places(world);
  world.stepSimulation(kStep, 0);
  const bullet::WorldDetection& detection = world.detection();
  Counts counts{};
  std::size_t i = 0;
  for (const bullet::DetectorReport report :
       {detection.contacts(), detection.rigid_meshes(), detection.convex_shapes()}) {
    counts[i++] = report.statistics().vt_contacts + report.statistics().ee_contacts;
    EXPECT_EQ(report.failed_steps(), 0U);
  }
  for (int step = 1; step < 10; ++step) world.stepSimulation(kStep, 0);
  EXPECT_GT(places.lowest(), 0) << "nothing is pushed through the mesh";
  return counts;
}

class ThreadedDispatchers : public testing::Test {
 protected:
  static void SetUpTestSuite() { set_task_scheduler(); }

  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btSequentialImpulseConstraintSolver solver_;
  btCollisionDispatcher plain_{&configuration_};
  /// One pair at a time is a thread's.
  btCollisionDispatcherMt threaded_{&configuration_, 1};
};

TEST_F(ThreadedDispatchers, find_the_same_contacts_as_others) {
  const auto contacts_with = [&](btCollisionDispatcher& dispatcher) {
    btDbvtBroadphase broadphase;
    bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver_, &configuration_, nullptr, all_contacts());
    return first_contacts(world);
  };
  const Counts expected = contacts_with(plain_);
  for (const std::uint64_t count : expected) EXPECT_GT(count, 0U) << testing::PrintToString(expected);
  for (int times = 0; times < 3; ++times) EXPECT_EQ(contacts_with(threaded_), expected);
}

}  // namespace
}  // namespace softcd::test
