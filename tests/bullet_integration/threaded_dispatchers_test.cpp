// Bullet's multithreaded dispatcher with more pairs than threads. If Bullet was built with BT_THREADSAFE, it calls
// softcd from all of them: tests/thread_safe_bullet.sh.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
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

/// In each place two sheets touch each other, and the lower one touches a box and two rigid meshes. The meshes extend
/// through all places, and their order decides the last digits of the sheet's motion. Bullet's own contacts of a sheet
/// with its box share nothing with other threads. Each sheet has its own box, because Bullet appends contacts without a
/// lock. It has its own btSoftBodyWorldInfo, because other threads would read its m_sparsesdf while it is filled.
class Places {
 public:
  explicit Places(btSoftRigidDynamicsWorld& world) : world_(world) {
    add_ground(flat_, 0, 0);
    add_ground(sloping_, btScalar(0.1), btScalar(-0.05));
    SheetOptions options;
    options.nodes_per_side = 5;
    for (int place = 0; place < kPlaces; ++place) {
      const btVector3 at(btScalar(3 * place), 0, 0);
      add_rigid(box_, at + btVector3(btScalar(0.1), btScalar(-0.08), 0));
      for (const btScalar height : {btScalar(0.04), btScalar(0.11)}) {
        options.height = height;
        world_infos_.push_back(std::make_unique<btSoftBodyWorldInfo>(world_.getWorldInfo()));
        world_infos_.back()->m_gravity = world_.getGravity();
        sheets_.push_back(make_sheet(*world_infos_.back(), options));
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

  std::vector<btScalar> positions() const {
    std::vector<btScalar> positions;
    for (const auto& sheet : sheets_) {
      for (int n = 0; n < sheet->m_nodes.size(); ++n) {
        const btVector3& position = sheet->m_nodes[n].m_x;
        positions.insert(positions.end(), {position.x(), position.y(), position.z()});
      }
    }
    return positions;
  }

 private:
  struct Ground {
    btTriangleMesh triangles;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
  };

  void add_ground(Ground& ground, btScalar slope, btScalar height) {
    const auto at = [&](btScalar x, btScalar z) { return btVector3(x, height + slope * z, z); };
    ground.triangles.addTriangle(at(-300, -300), at(0, 600), at(300, -300));
    ground.shape = std::make_unique<btBvhTriangleMeshShape>(&ground.triangles, true);
    add_rigid(*ground.shape, btVector3(0, 0, 0));
  }

  void add_rigid(btCollisionShape& shape, const btVector3& center) {
    rigid_bodies_.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, &shape));
    rigid_bodies_.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), center));
    world_.addRigidBody(rigid_bodies_.back().get());
  }

  btSoftRigidDynamicsWorld& world_;
  Ground flat_;
  Ground sloping_;
  btBoxShape box_{btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2))};
  std::vector<std::unique_ptr<btRigidBody>> rigid_bodies_;
  std::vector<std::unique_ptr<btSoftBodyWorldInfo>> world_infos_;
  std::vector<std::unique_ptr<btSoftBody>> sheets_;
};

bullet::Settings all_contacts() {
  bullet::Settings settings = careful_settings();
  settings.convex_shapes = bullet::ConvexShapes::faces_and_edges;
  return settings;
}

struct Outcome {
  /// Contacts in the first step: between soft bodies, with the meshes, with the boxes.
  std::array<std::uint64_t, 3> first_contacts{};
  /// After 20 steps.
  std::vector<btScalar> positions;
};

Outcome outcome_in(bullet::SoftRigidDynamicsWorld& world) {
  const Places places(world);
  world.stepSimulation(kStep, 0);
  const bullet::WorldDetection& detection = world.detection();
  Outcome outcome;
  std::size_t i = 0;
  for (const bullet::DetectorReport report :
       {detection.contact_report(), detection.rigid_mesh_report(), detection.convex_shape_report()}) {
    outcome.first_contacts[i++] = report.statistics().vt_contacts + report.statistics().ee_contacts;
  }
  for (int step = 1; step < 20; ++step) world.stepSimulation(kStep, 0);
  for (const bullet::DetectorReport report :
       {detection.contact_report(), detection.rigid_mesh_report(), detection.convex_shape_report()}) {
    EXPECT_EQ(report.failed_steps(), 0U);
  }
  EXPECT_GT(places.lowest(), 0) << "nothing is pushed through the meshes";
  outcome.positions = places.positions();
  return outcome;
}

/// Comes upon pairs as threads may: not in the order of the cache.
class BackwardDispatcher : public btCollisionDispatcher {
 public:
  using btCollisionDispatcher::btCollisionDispatcher;

  void dispatchAllCollisionPairs(btOverlappingPairCache* pair_cache, const btDispatcherInfo& info,
                                 btDispatcher* /*dispatcher*/) override {
    for (int i = pair_cache->getNumOverlappingPairs() - 1; i >= 0; --i) {
      getNearCallback()(pair_cache->getOverlappingPairArrayPtr()[i], *this, info);
    }
  }
};

class ThreadedDispatchers : public testing::Test {
 protected:
  static void SetUpTestSuite() { set_task_scheduler(); }

  Outcome outcome_with(btCollisionDispatcher& dispatcher, bool sorts_pairs = false) {
    btDbvtBroadphase broadphase;
    bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver_, &configuration_, nullptr, all_contacts());
    world.getDispatchInfo().m_deterministicOverlappingPairs = sorts_pairs;
    return outcome_in(world);
  }

  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btSequentialImpulseConstraintSolver solver_;
  btCollisionDispatcher plain_{&configuration_};
};

TEST_F(ThreadedDispatchers, find_the_same_contacts_as_others) {
  const Outcome expected = outcome_with(plain_);
  for (const std::uint64_t count : expected.first_contacts) EXPECT_GT(count, 0U);
  // One pair at a time is a thread's.
  btCollisionDispatcherMt threaded(&configuration_, 1);
  for (int times = 0; times < 3; ++times) {
    const Outcome outcome = outcome_with(threaded);
    EXPECT_EQ(outcome.first_contacts, expected.first_contacts);
    EXPECT_TRUE(outcome.positions == expected.positions) << "positions depend on threads";
  }
}

TEST_F(ThreadedDispatchers, may_come_upon_pairs_in_any_order) {
  BackwardDispatcher backward(&configuration_);
  for (const bool sorts_pairs : {false, true}) {
    EXPECT_TRUE(outcome_with(backward, sorts_pairs).positions == outcome_with(plain_, sorts_pairs).positions)
        << (sorts_pairs ? "where Bullet sorts pairs" : "where Bullet takes pairs as its cache has them");
  }
}

}  // namespace
}  // namespace softcd::test
