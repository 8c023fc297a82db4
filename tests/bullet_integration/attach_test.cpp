// softcd in worlds that other code has made: its effect there, and what it leaves after detaching.

#include "attached_worlds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "softcd/bullet/dispatcher.hpp"

namespace softcd::test {
namespace {

using bullet::attach;
using bullet::Attachment;
using bullet::Limit;
using bullet::OnError;
using bullet::ReadOut;

class Attach : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, Attach, kBulletsWorlds, world_name);

class AttachClassic : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, AttachClassic, testing::Values(World::one_line, World::multi_body), world_name);

TEST_P(Attach, says_what_it_cannot_do) {
  Sheets sheets(GetParam());
  const Attachment attachment = attach(sheets.world(), cpu_settings());
  std::vector<Limit> limits;
  for (const bullet::Limitation& limitation : attachment.limitations()) {
    limits.push_back(limitation.limit);
    EXPECT_THAT(std::string(limitation.text), testing::EndsWith("."));
  }
  std::vector<Limit> expected = {Limit::updates_trees};
  if (GetParam() != World::deformable) expected.push_back(Limit::ends_steps_late);
  EXPECT_THAT(limits, testing::UnorderedElementsAreArray(expected));
}

TEST_P(Attach, refuses_worlds_that_softcd_is_in_already) {
  Sheets sheets(GetParam());
  std::optional<Attachment> attachment = attach(sheets.world(), cpu_settings());
  EXPECT_THROW((void)attach(sheets.world(), cpu_settings()), InvalidInput);
  EXPECT_TRUE(attachment->is_attached());
  sheets.step();
  EXPECT_GT(found_by(*attachment), 0U);
  attachment->detach();
  EXPECT_FALSE(attachment->is_attached());
  attachment = attach(sheets.world(), cpu_settings());
  sheets.step();
  EXPECT_GT(found_by(*attachment), 0U);
  Sheets own(GetParam(), 1, cpu_settings());
  EXPECT_THROW((void)attach(own.world(), cpu_settings()), InvalidInput);
}

TEST(Attach, refuses_a_world_under_softcds_dispatcher_and_one_without_soft_bodies) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btSequentialImpulseConstraintSolver solver;
  bullet::Broadphase broadphase(std::make_unique<btDbvtBroadphase>());
  bullet::Dispatcher dispatcher(&configuration, broadphase, cpu_settings());
  btSoftRigidDynamicsWorld detected(&dispatcher, &broadphase, &solver, &configuration);
  EXPECT_THROW((void)attach(detected, cpu_settings()), InvalidInput);
  btDbvtBroadphase plain;
  btDiscreteDynamicsWorld rigid(&dispatcher, &plain, &solver, &configuration);
  EXPECT_THROW((void)attach(rigid, cpu_settings()), InvalidInput);
  EXPECT_EQ(rigid.getBroadphase(), &plain);
}

/// An app's own dispatcher, which processes pairs itself.
struct PassingBy : btCollisionDispatcher {
  using btCollisionDispatcher::btCollisionDispatcher;
  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info, btDispatcher*) override {
    for (int i = 0; i < pairs->getNumOverlappingPairs(); ++i) {
      getNearCallback()(pairs->getOverlappingPairArrayPtr()[i], *this, info);
    }
  }
};

template <class Dispatcher>
class UnderDispatcher : public testing::Test {};
using PassingDispatchers = testing::Types<PassingBy, btCollisionDispatcherMt>;
TYPED_TEST_SUITE(UnderDispatcher, PassingDispatchers);

TYPED_TEST(UnderDispatcher, that_passes_the_pair_cache_by_attached_softcd_leaves_rigid_meshes_alone) {
  set_task_scheduler();
  constexpr bool kIsKnown = std::is_same_v<TypeParam, btCollisionDispatcherMt>;
  std::vector<std::string> said;
  bullet::Settings settings = cpu_settings();
  settings.log = [&](LogLevel, std::string_view text) { said.emplace_back(text); };
  OwnWorld own;
  own.dispatcher = std::make_unique<TypeParam>(&own.configuration);
  own.make(std::nullopt);
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btSequentialImpulseConstraintSolver solver;
  TypeParam dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSoftRigidDynamicsWorld classic(&dispatcher, &broadphase, &solver, &configuration);
  classic.getWorldInfo().m_gravity.setZero();
  const auto is_last_limit = [](const Attachment& attachment) {
    return (attachment.limitations().end() - 1)->limit == Limit::leaves_rigid_meshes;
  };

  Attachment to_classic = attach(classic, settings);
  Attachment to_deformable = attach(*own.world, settings);
  std::vector<std::unique_ptr<btSoftBody>> sheets;
  for (const btScalar height : {btScalar(0), btScalar(0.03)}) {
    own.add(make_small_sheet(own.world->getWorldInfo(), height));
    sheets.push_back(make_small_sheet(classic.getWorldInfo(), height));
    sheets.back()->m_cfg.piterations = 0;
    classic.addSoftBody(sheets.back().get());
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(is_last_limit(to_classic), kIsKnown || i > 0);
    own.world->stepSimulation(kShortStep, 0);
    classic.stepSimulation(kStep, 0);
    EXPECT_EQ(sheets[0]->m_scontacts.size() + sheets[1]->m_scontacts.size(), int(found_by(to_classic)));
    EXPECT_EQ(count_contacts(own.world->getSoftBodyArray()), int(found_by(to_deformable)));
    EXPECT_GT(found_by(to_classic), 0U);
    EXPECT_GT(found_by(to_deformable), 0U);
  }
  EXPECT_TRUE(is_last_limit(to_deformable));
  EXPECT_EQ(to_classic.detection().rigid_mesh_report().failed_steps(), kIsKnown ? 0U : 1U);
  EXPECT_EQ(said.size(), kIsKnown ? 0U : 2U);
  to_deformable.detach();
  to_classic.detach();
  for (const auto& sheet : sheets) classic.removeSoftBody(sheet.get());
}

/// Counts the calls of a world's tick callbacks.
struct Ticks {
  int before = 0, after = 0;
  std::function<void()> on_before, on_after;

  void set_in(btDynamicsWorld& world) {
    world.setInternalTickCallback(count<&Ticks::before, &Ticks::on_before>, this, /*isPreTick=*/true);
    world.setInternalTickCallback(count<&Ticks::after, &Ticks::on_after>, this, /*isPreTick=*/false);
  }

 private:
  template <int Ticks::*counter, std::function<void()> Ticks::*on>
  static void count(btDynamicsWorld* world, btScalar) {
    auto& ticks = *static_cast<Ticks*>(world->getWorldUserInfo());
    ++(ticks.*counter);
    if (ticks.*on) (ticks.*on)();
  }
};

TEST_P(Attach, calls_the_apps_tick_callbacks_and_gives_them_back) {
  Sheets sheets(GetParam());
  Ticks ticks;
  ticks.set_in(sheets.world());
  btBroadphaseInterface* const broadphase = sheets.world().getBroadphase();
  std::optional<Attachment> attachment = attach(sheets.world(), cpu_settings());
  EXPECT_NE(sheets.world().getBroadphase(), broadphase);
  const btScalar step = sheets.simulation.step_length();
  EXPECT_EQ(sheets.world().stepSimulation(3 * step + step / 8, 10, step), 3);
  EXPECT_EQ(ticks.before, 3);
  EXPECT_EQ(ticks.after, 3);
  EXPECT_GT(found_by(*attachment), 0U);
  attachment.reset();
  EXPECT_EQ(sheets.world().getBroadphase(), broadphase);
  EXPECT_EQ(sheets.world().getWorldUserInfo(), &ticks);
  sheets.step();
  EXPECT_EQ(ticks.before, 4);
  EXPECT_EQ(ticks.after, 4);
}

TEST_P(Attach, goes_on_when_the_app_sets_tick_callbacks_meanwhile) {
  Sheets sheets(GetParam());
  Attachment attachment = attach(sheets.world(), cpu_settings(Detection::ccd));
  sheets.step();
  Ticks ticks;
  ticks.set_in(sheets.world());
  for (int i = 1; i <= 3; ++i) {
    sheets.step();
    EXPECT_EQ(ticks.before, i);
    EXPECT_EQ(ticks.after, i);
    EXPECT_GT(found_by(attachment), 0U);
    EXPECT_EQ(failed_steps_of(attachment), 0U);
    EXPECT_EQ(attachment.detection().crossing_report().failed_steps(), GetParam() == World::deformable ? 0U : 1U);
  }
  attachment.finish_step();
  ticks.set_in(sheets.world());
  sheets.step();
  EXPECT_LE(attachment.detection().crossing_report().failed_steps(), 1U)
      << "where the step was finished, nothing is missed";
  Ticks others;
  others.set_in(sheets.world());
  attachment.detach();
  sheets.step();
  EXPECT_EQ(others.before, 1) << "those that were set last stay";
  EXPECT_EQ(ticks.before, 4);
}

TEST_P(Attach, begins_and_ends_between_substeps) {
  for (const bool before : {false, true}) {
    Sheets sheets(GetParam());
    Ticks ticks;
    ticks.set_in(sheets.world());
    std::optional<Attachment> attachment;
    std::vector<std::uint64_t> found;
    const auto on_tick = [&] {
      found.push_back(attachment.has_value() && attachment->is_attached() ? found_by(*attachment) : 0);
      if (found.size() == 2) attachment = attach(sheets.world(), cpu_settings());
      if (found.size() == 5) attachment->detach();
    };
    (before ? ticks.on_before : ticks.on_after) = on_tick;
    const btScalar step = sheets.simulation.step_length();
    EXPECT_EQ(sheets.world().stepSimulation(7 * step + step / 8, 10, step), 7);
    ASSERT_EQ(found.size(), 7U);
    EXPECT_GT(found[3], 0U);
    EXPECT_GT(found[4], 0U);
    EXPECT_EQ(ticks.before, 7);
    EXPECT_EQ(ticks.after, 7);
    EXPECT_EQ(failed_steps_of(*attachment), 0U);
    EXPECT_FALSE(contacts_in(sheets.simulation).empty());
    sheets.step();
  }
}

TEST_P(Attach, begins_and_ends_in_actions) {
  Sheets sheets(GetParam());
  Action action;
  std::optional<Attachment> attachment;
  int updates = 0;
  action.on_update = [&] {
    if (++updates == 2) attachment = attach(sheets.world(), cpu_settings(Detection::ccd));
    if (updates == 4) {
      EXPECT_GT(found_by(*attachment), 0U);
    }
    if (updates == 5) attachment->detach();
  };
  sheets.world().addAction(&action);
  for (int i = 0; i < 7; ++i) sheets.step();
  EXPECT_EQ(updates, 7);
  EXPECT_EQ(failed_steps_of(*attachment), 0U);
  EXPECT_FALSE(contacts_in(sheets.simulation).empty());
  sheets.world().removeAction(&action);
}

TEST_P(Attach, follows_bodies_that_come_and_go) {
  bullet::Settings settings = reading(ReadOut::impulses, Detection::ccd);
  Sheets sheets(GetParam(), 5);
  const Attachment attachment = attach(sheets.world(), settings);
  const auto add = [&] {
    SheetOptions options;
    options.nodes_per_side = 5;
    options.height = btScalar(0.08);
    return &sheets.simulation.add(make_sheet(sheets.simulation.world_info(), options));
  };
  sheets.step();
  EXPECT_EQ(found_by(attachment), 0U);
  for (int i = 0; i < 3; ++i) {
    btSoftBody* added = add();
    sheets.step();
    EXPECT_GT(found_by(attachment), 0U);
    const std::unique_ptr<btSoftBody> removed = sheets.simulation.remove(*added);
    const auto flags = removed->m_cfg.collisions;
    EXPECT_NE(flags & (btSoftBody::fCollision::VF_SS | btSoftBody::fCollision::VF_DD), 0);
  }
  sheets.step();
  EXPECT_EQ(found_by(attachment), 0U);
  EXPECT_EQ(failed_steps_of(attachment), 0U);
}

/// Bullet's build of face trees, quadratic in the faces, never ends for faces that no links connect.
TEST_P(Attach, spares_bodies_that_come_the_build_of_face_trees_until_it_is_detached) {
  Sheets sheets(GetParam());
  Attachment attachment = attach(sheets.world(), cpu_settings());
  sheets.step();
  EXPECT_TRUE(sheets.free->m_fdbvt.empty());
  attachment.detach();
  EXPECT_FALSE(sheets.free->m_fdbvt.empty());
  sheets.step();
  EXPECT_FALSE(contacts_in(sheets.simulation).empty()) << "Bullet's own";
}

TEST_P(Attach, may_be_destroyed_before_the_world) {
  Sheets sheets(GetParam());
  btBroadphaseInterface* const broadphase = sheets.world().getBroadphase();
  {
    Attachment first = attach(sheets.world(), cpu_settings(Detection::ccd));
    sheets.step();
    const Attachment second = std::move(first);
    EXPECT_TRUE(second.is_attached());
    EXPECT_FALSE(first.is_attached());  // NOLINT(bugprone-use-after-move): the state after a move
  }
  EXPECT_EQ(sheets.world().getBroadphase(), broadphase);
  sheets.step();
}

TEST_P(AttachClassic, notices_a_world_that_is_destroyed_with_bodies_in_it) {
  Sheets sheets(GetParam());
  Attachment attachment = attach(sheets.world(), reading(ReadOut::impulses, Detection::ccd));
  sheets.step();
  sheets.simulation.destroy_world();
  EXPECT_FALSE(attachment.is_attached());
  attachment.finish_step();
  attachment.detach();
  EXPECT_NE(sheets.free->m_cfg.collisions & btSoftBody::fCollision::VF_SS, 0);
  for (const bullet::BodyPairContacts& pair : attachment.detection().body_contacts()) EXPECT_EQ(pair.a, nullptr);
}

TEST_P(AttachClassic, ends_a_step_when_the_next_begins_or_finish_step_is_called) {
  const auto run = [&](bool finishes_steps) {
    Sheets sheets(GetParam(), btScalar(0.3));
    for (btSoftBody* body : {sheets.held, sheets.free}) body->m_cfg.piterations = 0;  // no response to contacts
    sheets.free->setVelocity(btVector3(0, -40, 0));
    Attachment attachment = attach(sheets.world(), cpu_settings(Detection::ccd));
    sheets.step();
    EXPECT_LT(mean_height(*sheets.free), 0) << "where Bullet's solver has left it";
    EXPECT_EQ(attachment.detection().crossing_answers().impacts, 0U);
    if (finishes_steps) {
      attachment.finish_step();
      EXPECT_GT(lowest_height(*sheets.free), 0);
      EXPECT_GT(attachment.detection().crossing_answers().impacts, 0U);
    }
    sheets.step();
    attachment.detach();
    EXPECT_GT(lowest_height(*sheets.free), 0);
    return states_in(sheets.simulation);
  };
  EXPECT_EQ(run(true), run(false));
}

/// The app changes bodies before a step is finished: bodies are replaced, and have other faces.
TEST_P(AttachClassic, finishes_a_step_with_bodies_that_are_no_more_what_they_were) {
  Sheets sheets(GetParam(), btScalar(0.08));
  const Attachment attachment = attach(sheets.world(), reading(ReadOut::impulses, Detection::ccd));
  sheets.step();
  sheets.simulation.remove(*sheets.free).reset();
  SheetOptions options;
  options.nodes_per_side = 7;
  options.height = btScalar(0.07);
  sheets.free = &sheets.simulation.add(make_sheet(sheets.simulation.world_info(), options));
  sheets.step();
  sheets.free->appendNode(btVector3(0, 1, 0), 1);
  sheets.free->appendFace(0, 1, sheets.free->m_nodes.size() - 1);
  sheets.step();
  EXPECT_GT(found_by(attachment), 0U);
  EXPECT_EQ(failed_steps_of(attachment) + attachment.detection().crossing_report().failed_steps(), 0U);
}

TEST_P(Attach, knows_the_impulses_of_softcds_own_world) {
  bullet::Settings settings = reading(ReadOut::impulses);
  Sheets own(GetParam(), btScalar(0.08), settings);
  Sheets bullets(GetParam());
  for (btSoftBody* body : {own.free, bullets.free}) body->m_cfg.piterations = 4;
  int callbacks = 0;
  settings.on_contacts = [&](const std::vector<bullet::BodyPairContacts>&) { ++callbacks; };
  Attachment attachment = attach(bullets.world(), settings);
  for (int i = 1; i <= 3; ++i) {
    own.step();
    bullets.step();
    attachment.finish_step();
    EXPECT_EQ(callbacks, i);
    const std::vector<bullet::BodyPairContacts>& pairs = attachment.detection().body_contacts();
    const std::vector<bullet::BodyPairContacts>& expected = own.simulation.detection().body_contacts();
    ASSERT_EQ(pairs.size(), 1U);
    ASSERT_EQ(expected.size(), 1U);
    EXPECT_TRUE(expected[0].has_impulses && pairs[0].has_impulses);
    EXPECT_EQ(pairs[0].impulse_a, expected[0].impulse_a);
    EXPECT_EQ(pairs[0].impulse_b, expected[0].impulse_b);
    EXPECT_TRUE(i > 1 || pairs[0].impulse_a.length() + pairs[0].impulse_b.length() > 0);
  }
}

TEST_P(Attach, knows_the_impulses_of_rigid_objects) {
  Sheets sheets(GetParam(), btScalar(1));
  sheets.free->m_cfg.piterations = 4;
  sheets.free->setVelocity(btVector3(0, -1, 0));
  sheets.simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(2, btScalar(0.1), 2)),
                              btVector3(0, btScalar(0.87), 0));
  Attachment attachment = attach(sheets.world(), reading(ReadOut::impulses));
  sheets.step();
  attachment.finish_step();
  const std::vector<bullet::BodyPairContacts>& pairs = attachment.detection().body_contacts();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_TRUE(pairs[0].has_impulses);
  EXPECT_GT(pairs[0].impulse_a.y(), 0);
}

TEST_P(Attach, leaves_contacts_with_convex_objects_as_they_are_in_softcds_own_world_but_for_their_order) {
  const auto nodes_in_contact = [&](const MaybeSettings& of_softcds_own) {
    Sheets sheets(GetParam(), btScalar(1), of_softcds_own);
    sheets.free->setVelocity(btVector3(0, -1, 0));
    sheets.simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(btScalar(0.3), btScalar(0.1), btScalar(0.3))),
                                btVector3(btScalar(0.1), btScalar(0.87), 0));
    std::optional<Attachment> attachment;
    if (!of_softcds_own.has_value()) attachment = attach(sheets.world(), cpu_settings());
    sheets.step();
    const btSoftBody& body = *sheets.free;
    std::multiset<const btSoftBody::Node*> nodes;
    for (int i = 0; i < body.m_rcontacts.size(); ++i) nodes.insert(body.m_rcontacts[i].m_node);
    for (int i = 0; i < body.m_nodeRigidContacts.size(); ++i) nodes.insert(body.m_nodeRigidContacts[i].m_node);
    std::vector<std::ptrdiff_t> indices;
    for (const btSoftBody::Node* node : nodes) indices.push_back(node - &body.m_nodes[0]);
    return indices;
  };
  const std::vector<std::ptrdiff_t> attached = nodes_in_contact(std::nullopt);
  EXPECT_GT(attached.size(), 3U);
  EXPECT_LT(attached.size(), 25U);
  EXPECT_EQ(attached, nodes_in_contact(cpu_settings()));
}

/// A step in which softcd fails has Bullet's own contacts, and one that an app's exception leaves is no obstacle.
TEST_P(Attach, goes_on_after_exceptions) {
  Sheets sheets(GetParam());
  std::vector<std::string> said;
  bullet::Settings settings = cpu_settings(Detection::ccd);
  settings.log = [&](LogLevel, std::string_view text) {
    said.emplace_back(text);
    if (text.find("finite") != std::string_view::npos) throw Error("from the log");
  };
  Attachment attachment = attach(sheets.world(), settings);
  sheets.step();
  btSoftBody::Node& node = sheets.free->m_nodes[sheets.free->m_nodes.size() - 1];
  const btVector3 place = node.m_x;
  node.m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
  EXPECT_NO_THROW(sheets.step());
  EXPECT_EQ(failed_steps_of(attachment), 1U);
  EXPECT_FALSE(said.empty());
  EXPECT_FALSE(contacts_in(sheets.simulation).empty()) << "Bullet's own";
  node.m_x = node.m_q = place;
  node.m_v.setZero();
  sheets.simulation.dispatcher().setNearCallback(
      [](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) { throw std::domain_error("the app's"); });
  EXPECT_THROW(sheets.step(), std::domain_error);
  sheets.simulation.dispatcher().setNearCallback(btCollisionDispatcher::defaultNearCallback);
  sheets.simulation.remove(*sheets.free).reset();
  SheetOptions options;
  options.height = btScalar(0.08);
  sheets.free = &sheets.simulation.add(make_sheet(sheets.simulation.world_info(), options));
  sheets.step();
  EXPECT_EQ(failed_steps_of(attachment), 1U);
  EXPECT_GT(found_by(attachment), 0U);
}

TEST_P(Attach, lets_an_action_throw) {
  Sheets sheets(GetParam());
  Action action;
  action.on_update = [] { throw std::domain_error("the app's"); };
  sheets.world().addAction(&action);
  Attachment attachment = attach(sheets.world(), cpu_settings(Detection::ccd));
  EXPECT_THROW(sheets.step(), std::domain_error);
  action.on_update = [] {};
  bullet::give_face_tree(*sheets.free);
  sheets.step();
  EXPECT_FALSE(sheets.free->m_fdbvt.empty());
  EXPECT_GT(found_by(attachment), 0U);
  action.on_update = [] { throw std::domain_error("the app's"); };
  EXPECT_THROW(sheets.step(), std::domain_error);
  attachment.detach();
  EXPECT_FALSE(sheets.free->m_fdbvt.empty());
  sheets.world().removeAction(&action);
}

TEST_P(Attach, may_throw_an_error_where_that_is_asked_for) {
  Sheets sheets(GetParam());
  bullet::Settings settings = cpu_settings();
  settings.on_error = OnError::throw_error;
  settings.log = [&](LogLevel, std::string_view) { throw Error("from the log"); };
  const Attachment attachment = attach(sheets.world(), settings);
  sheets.free->m_nodes[0].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
  EXPECT_THROW(sheets.step(), Error);
}

}  // namespace
}  // namespace softcd::test
