// Peculiarities of softcd in a deformable world that other code has made: trees and anchors.

#include "attached_worlds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btBoxShape.h"

namespace softcd::test {
namespace {

using bullet::attach;
using bullet::Attachment;

TEST(AttachDeformable, notices_a_world_that_is_destroyed_with_bodies_in_it) {
  OwnWorld own;
  own.make(std::nullopt);
  for (const btScalar height : {btScalar(0), btScalar(0.03)}) {
    own.add(make_small_sheet(own.world->getWorldInfo(), height));
  }
  btSoftBodyWorldInfo info = own.world->getWorldInfo();
  Attachment attachment = attach(*own.world, cpu_settings());
  own.world->stepSimulation(kShortStep, 0);
  EXPECT_GT(found_by(attachment), 0U);
  own.world.reset();
  EXPECT_FALSE(attachment.is_attached());
  attachment.detach();
  own.bodies.clear();
}

/// softcd builds bodies that touch rigid objects with their faces a tree, which has no twin with normals.
TEST(AttachDeformable, gives_back_trees_in_which_bullet_finds_contacts_within_a_body) {
  Sheets sheets(World::deformable);
  sheets.simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(2, btScalar(0.1), 2)),
                              btVector3(0, btScalar(0.22), 0));
  sheets.free->m_cfg.collisions |= btSoftBody::fCollision::SDF_RDF;
  Attachment attachment = attach(sheets.world(), cpu_settings());
  sheets.step();
  EXPECT_FALSE(sheets.free->m_fdbvt.empty());
  EXPECT_GT(sheets.free->m_faceRigidContacts.size(), 0);
  attachment.detach();
  EXPECT_NE(sheets.free->m_fdbvnt, nullptr);
}

TEST(AttachDeformable, goes_on_calling_an_apps_solver_callback) {
  static int first_calls, second_calls;
  first_calls = second_calls = 0;
  Sheets sheets(World::deformable);
  auto& world = dynamic_cast<btDeformableMultiBodyDynamicsWorld&>(sheets.world());
  world.setSolverCallback([](btScalar, btDeformableMultiBodyDynamicsWorld*) { ++first_calls; });
  sheets.step();
  const int calls_of_step = first_calls;
  EXPECT_EQ(calls_of_step, 2) << "before the solver and after it";
  Attachment attachment = attach(sheets.world(), cpu_settings());
  sheets.step();
  EXPECT_EQ(first_calls, 2 * calls_of_step);
  attachment.detach();
  sheets.step();
  EXPECT_EQ(first_calls, 3 * calls_of_step);
  const Attachment again = attach(sheets.world(), cpu_settings());
  world.setSolverCallback([](btScalar, btDeformableMultiBodyDynamicsWorld*) { ++second_calls; });
  for (int step = 0; step < 3; ++step) sheets.step();
  EXPECT_EQ(first_calls, 3 * calls_of_step);
  EXPECT_EQ(second_calls, 3 * calls_of_step);
}

/// Vehicles do.
TEST(AttachDeformable, casts_rays_in_actions_at_the_trees_that_there_are) {
  Sheets sheets(World::deformable);
  Action action;
  btCollisionWorld::ClosestRayResultCallback hit(btVector3(0, 3, 0), btVector3(0, -3, 0));
  action.on_update = [&] { sheets.world().rayTest(btVector3(0, 3, 0), btVector3(0, -3, 0), hit); };
  sheets.world().addAction(&action);
  bullet::give_face_tree(*sheets.free);
  sheets.step();
  const btDbvtNode* const tree = sheets.free->m_fdbvt.m_root;
  const Attachment attachment = attach(sheets.world(), cpu_settings());
  sheets.step();
  EXPECT_TRUE(hit.hasHit());
  EXPECT_EQ(hit.m_collisionObject, sheets.free);
  EXPECT_EQ(sheets.free->m_fdbvt.m_root, tree);
  sheets.world().removeAction(&action);
}

TEST(AttachDeformable, keeps_a_tree_that_an_app_has_built_while_its_own_was_out_of_sight) {
  Sheets sheets(World::deformable);
  Action action;
  action.on_update = [&] {
    btSoftBody::sRayCast hit;
    EXPECT_TRUE(sheets.free->rayFaceTest(btVector3(0, 3, 0), btVector3(0, -3, 0), hit));
  };
  sheets.world().addAction(&action);
  sheets.step();
  const Attachment attachment = attach(sheets.world(), cpu_settings());
  for (int i = 0; i < 3; ++i) sheets.step();
  EXPECT_FALSE(sheets.free->m_fdbvt.empty());
  EXPECT_GT(found_by(attachment), 0U);
  sheets.world().removeAction(&action);
}

TEST(AttachDeformable, leaves_anchored_nodes_where_anchors_hold_them) {
  const auto run = [](const MaybeSettings& of_softcds_own) {
    Sheets sheets(World::deformable, btScalar(0.3), of_softcds_own);
    btRigidBody& box = sheets.simulation.add_rigid(
        std::make_unique<btBoxShape>(btVector3(btScalar(0.05), btScalar(0.05), btScalar(0.05))),
        btVector3(btScalar(-0.3), btScalar(0.3), btScalar(-0.3)));
    sheets.free->appendDeformableAnchor(0, &box);
    sheets.free->setVelocity(btVector3(0, -90, 0));
    std::optional<Attachment> attachment;
    if (!of_softcds_own.has_value()) attachment = attach(sheets.world(), cpu_settings(Detection::ccd));
    sheets.step();
    const std::uint64_t impacts =
        (attachment.has_value() ? attachment->detection() : sheets.simulation.detection()).crossing_answers().impacts;
    EXPECT_GT(impacts, 0U);
    return states_in(sheets.simulation);
  };
  EXPECT_EQ(run(std::nullopt), run(cpu_settings(Detection::ccd)));
}

}  // namespace
}  // namespace softcd::test
