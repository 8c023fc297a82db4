// Set-ups as apps have them, put together from Bullet's own parts.

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btAxisSweep3.h"
#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"
#include "BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h"
#include "LinearMath/btThreads.h"
#include "soft_body_support.hpp"
#include "softcd/bullet/dispatcher.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::test {
namespace {

/// Two sheets within each other's reach in a world of the test's.
template <class World>
class AppSheets {
 public:
  explicit AppSheets(World& world) : AppSheets(world, world.getWorldInfo()) {}
  AppSheets(World& world, btSoftBodyWorldInfo& info) : world_(world) {
    info.m_gravity.setZero();
    SheetOptions options;
    options.margin = btScalar(0.02);
    lower_ = make_sheet(info, options);
    options.height = btScalar(0.03);
    upper_ = make_sheet(info, options);
    world_.addSoftBody(lower_.get());
    world_.addSoftBody(upper_.get());
  }
  ~AppSheets() {
    world_.removeSoftBody(lower_.get());
    world_.removeSoftBody(upper_.get());
  }
  AppSheets(const AppSheets&) = delete;
  AppSheets& operator=(const AppSheets&) = delete;

  int step() {
    world_.stepSimulation(kStep, 0);
    return lower_->m_scontacts.size() + upper_->m_scontacts.size();
  }

  bool has_duplicates() const {
    std::set<std::pair<const btSoftBody::Node*, const btSoftBody::Face*>> seen;
    for (const btSoftBody* body : {lower_.get(), upper_.get()}) {
      for (int i = 0; i < body->m_scontacts.size(); ++i) {
        if (!seen.emplace(body->m_scontacts[i].m_node, body->m_scontacts[i].m_face).second) return true;
      }
    }
    return false;
  }

 private:
  World& world_;
  std::unique_ptr<btSoftBody> lower_, upper_;
};

class Apps : public testing::Test {
 protected:
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btMultiBodyConstraintSolver solver{};  // worlds without multibodies read members that only {} initializes

  /// The contacts of one step in a world of that kind.
  template <class World>
  int contacts_with(btCollisionDispatcher& dispatcher) {
    btDbvtBroadphase broadphase;
    World world(&dispatcher, &broadphase, &solver, &configuration, nullptr, cpu_settings());
    AppSheets sheets(world);
    const int contacts = sheets.step();
    EXPECT_FALSE(sheets.has_duplicates());
    EXPECT_GT(world.detection().contact_report().statistics().vt_contacts, 0U);
    return contacts;
  }
};

TEST_F(Apps, a_multithreaded_dispatcher_works_in_one_line_worlds) {
  set_task_scheduler();
  btCollisionDispatcher plain(&configuration);
  btCollisionDispatcherMt multithreaded(&configuration);
  EXPECT_EQ(contacts_with<bullet::SoftRigidDynamicsWorld>(multithreaded),
            contacts_with<bullet::SoftRigidDynamicsWorld>(plain));
  EXPECT_EQ(contacts_with<bullet::SoftMultiBodyDynamicsWorld>(multithreaded),
            contacts_with<bullet::SoftMultiBodyDynamicsWorld>(plain));
}

TEST_F(Apps, any_broad_phase_and_an_apps_own_world_info_work) {
  btAxisSweep3 original(btVector3(-100, -100, -100), btVector3(100, 100, 100));
  bullet::Broadphase broadphase(original);
  bullet::Dispatcher dispatcher(&configuration, broadphase, cpu_settings());
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btSoftBodyWorldInfo info;
  info.m_broadphase = &broadphase;
  info.m_dispatcher = &dispatcher;
  AppSheets sheets(world, info);
  EXPECT_EQ(broadphase.soft_bodies().size(), 2U);
  EXPECT_GT(sheets.step(), 0);
  EXPECT_GT(dispatcher.detection().contact_report().statistics().vt_contacts, 0U);
}

TEST_F(Apps, a_one_line_world_leaves_detection_to_softcds_dispatcher) {
  bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  bullet::Dispatcher dispatcher(&configuration, broadphase, cpu_settings());
  bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  AppSheets sheets(world);
  EXPECT_GT(sheets.step(), 0);
  EXPECT_FALSE(sheets.has_duplicates());
  EXPECT_EQ(&world.detection(), &dispatcher.detection());
}

/// Returns the warnings of three steps in a world of that class on softcd's Dispatcher.
template <class World>
std::vector<std::string> warnings_on_dispatcher(btCollisionConfiguration& configuration,
                                                btMultiBodyConstraintSolver& solver, Detection first_step,
                                                Detection later_steps) {
  std::vector<std::string> warnings;
  bullet::Settings settings = cpu_settings(first_step);
  settings.log = [&warnings](LogLevel level, std::string_view text) {
    if (level == LogLevel::warning) warnings.emplace_back(text);
  };
  bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  bullet::Dispatcher dispatcher(&configuration, broadphase, settings);
  World world(&dispatcher, &broadphase, &solver, &configuration);
  AppSheets sheets(world);
  sheets.step();
  settings.detection = later_steps;
  dispatcher.detection().set_settings(settings);
  for (int step = 0; step < 2; ++step) sheets.step();
  return warnings;
}

TEST_F(Apps, a_dispatcher_under_bullets_world_says_once_that_it_prevents_no_crossings) {
  const auto warnings = [this](Detection first_step, Detection later_steps) {
    return warnings_on_dispatcher<btSoftRigidDynamicsWorld>(configuration, solver, first_step, later_steps);
  };
  EXPECT_TRUE(warnings(Detection::dcd, Detection::dcd).empty());
  EXPECT_EQ(warnings(Detection::ccd, Detection::dcd).size(), 1U);
  EXPECT_EQ(warnings(Detection::dcd, Detection::ccd).size(), 1U);
  const std::vector<std::string> both = warnings(Detection::ccd, Detection::ccd);
  ASSERT_EQ(both.size(), 1U);
  EXPECT_NE(both[0].find("pass through"), std::string::npos) << both[0];
  EXPECT_NE(both[0].find("softcd::bullet::attach"), std::string::npos) << "what to use instead";
}

TEST_F(Apps, a_dispatcher_under_a_one_line_world_has_nothing_to_say_of_crossings) {
  EXPECT_EQ(
      warnings_on_dispatcher<bullet::SoftRigidDynamicsWorld>(configuration, solver, Detection::ccd, Detection::ccd),
      std::vector<std::string>());
}

TEST_F(Apps, a_one_line_world_with_another_broad_phase_than_the_dispatchers_detects_itself) {
  bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  bullet::Dispatcher dispatcher(&configuration, broadphase, cpu_settings());
  btDbvtBroadphase other_broadphase;
  bullet::SoftRigidDynamicsWorld world(&dispatcher, &other_broadphase, &solver, &configuration, nullptr,
                                       cpu_settings());
  AppSheets sheets(world);
  EXPECT_GT(sheets.step(), 0);
  EXPECT_FALSE(sheets.has_duplicates());
  EXPECT_NE(&world.detection(), &dispatcher.detection());
}

TEST_F(Apps, a_second_world_on_the_dispatcher_gets_bullets_detection) {
  bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  bullet::Dispatcher dispatcher(&configuration, broadphase, cpu_settings());
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btDbvtBroadphase plain_broadphase;
  btSoftRigidDynamicsWorld plain_world(&dispatcher, &plain_broadphase, &solver, &configuration);
  AppSheets plain_sheets(plain_world);
  EXPECT_GT(plain_sheets.step(), 0);
  EXPECT_EQ(dispatcher.detection().contact_report().statistics().vt_contacts, 0U);
  AppSheets sheets(world);
  EXPECT_GT(sheets.step(), 0);
  EXPECT_GT(dispatcher.detection().contact_report().statistics().vt_contacts, 0U);
}

TEST_F(Apps, a_plain_world_on_the_dispatcher_of_a_one_line_world_keeps_bullets_detection) {
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase, plain_broadphase;
  const bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr,
                                             cpu_settings());
  btSoftRigidDynamicsWorld plain_world(&dispatcher, &plain_broadphase, &solver, &configuration);
  AppSheets plain_sheets(plain_world);
  EXPECT_GT(plain_sheets.step(), 0);
}

TEST_F(Apps, settings_can_change_at_run_time) {
  btDbvtBroadphase broadphase;
  btCollisionDispatcher dispatcher(&configuration);
  bullet::SoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, nullptr, cpu_settings());
  AppSheets sheets(world);
  EXPECT_GT(sheets.step(), 0);
  world.detection().set_settings(cpu_settings(Detection::ccd));
  EXPECT_EQ(world.detection().settings().detection, Detection::ccd);
  EXPECT_GT(sheets.step(), 0);
  EXPECT_FALSE(world.detection().contact_report().explain().empty());
}

}  // namespace
}  // namespace softcd::test
