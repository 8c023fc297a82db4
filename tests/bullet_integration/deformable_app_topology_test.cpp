// Bodies and meshes that change in the deformable world while the simulation runs, compared with Bullet's own result.

#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "deformable_app_support.hpp"

namespace softcd::test {
namespace {

using Flags = btSoftBody::fCollision;

TEST(DeformableAppTopology, bodies_come_and_go) {
  const auto run = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    sheets.add(0);
    Steps steps = {sheets.step()};
    btSoftBody& upper = sheets.add(btScalar(0.03));
    steps.push_back(sheets.step());
    std::unique_ptr<btSoftBody> removed = sheets.remove(upper);
    steps.push_back(sheets.step());
    btSoftBody& again = sheets.add(std::move(removed));
    steps.push_back(sheets.step());
    sheets.remove(again).reset();
    steps.push_back(sheets.step());
    // Perhaps where the last one was in memory.
    SheetOptions options;
    options.nodes_per_side = 5;
    options.height = btScalar(0.03);
    options.margin = btScalar(0.02);
    sheets.add(make_sheet(sheets.simulation().world_info(), options));
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {false, true, false, true, false, true});
}

TEST(DeformableAppTopology, bodies_move_to_another_world) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets from(settings);
    HeldSheets to(settings);
    to.add(btScalar(0.05));
    Steps steps = {from.step(), to.step()};
    std::unique_ptr<btSoftBody> moved = from.remove(from.upper);
    moved->m_worldInfo = &to.simulation().world_info();
    to.add(std::move(moved));
    steps.push_back(from.step());
    steps.push_back(to.step());
    EXPECT_EQ(from.lower.m_faceNodeContacts.size(), 0);
    return steps;
  };
  expect_steps_as_bullets(run, {true, false, false, true});
}

TEST(DeformableAppTopology, new_nodes_and_faces_collide) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    Steps steps = {sheets.step()};
    for (int i = 0; i < 3; ++i) {  // the arrays move to new memory
      const int added = sheets.upper.m_nodes.size();
      sheets.upper.appendNode(btVector3(btScalar(0.1) * btScalar(i), btScalar(0.02), btScalar(0.13)), 1);
      sheets.upper.appendFace(i, i + 1, added);
      sheets.upper.appendLink(i, added);
      sheets.hold(sheets.upper);
      steps.push_back(sheets.step());
      EXPECT_TRUE(std::any_of(steps.back().begin(), steps.back().end(),
                              [&](const auto& contact) { return contact[0] == 1 && contact[1] == added; }));
    }
    return steps;
  };
  expect_steps_as_bullets(run, {true, true, true, true});
}

TEST(DeformableAppTopology, faces_reordered_in_place_are_noticed) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    sheets.upper.rotate(btQuaternion(btVector3(1, 0, 0), btScalar(0.04)));
    sheets.hold(sheets.upper);
    Steps steps = {sheets.step()};
    sheets.upper.randomizeConstraints();
    steps.push_back(sheets.step());
    EXPECT_NE(steps[0], steps[1]);
    return steps;
  };
  expect_steps_as_bullets(run, {true, true});
}

class CuttingPlane : public btSoftBody::ImplicitFn {
 public:
  btScalar Eval(const btVector3& x) override { return x.x() - btScalar(0.07); }
};

TEST(DeformableAppTopology, refined_faces_collide) {
  const auto run = [](const MaybeSettings& settings) {
    TwoHeldSheets sheets(settings);
    Steps steps = {sheets.step()};
    const int faces = sheets.upper.m_faces.size();
    CuttingPlane plane;
    sheets.upper.refine(&plane, btScalar(0.001), /*cut=*/false);
    EXPECT_GT(sheets.upper.m_faces.size(), faces);
    sheets.hold(sheets.upper);
    steps.push_back(sheets.step());
    return steps;
  };
  expect_steps_as_bullets(run, {true, true});
}

// Bullet builds a face tree in the next step, in a loop that does not end for a mesh in two parts.
TEST(DeformableAppTopology, cut_cloths_collide) {
  for (const int more_flags : {0, int(Flags::SDF_RDF)}) {
    TwoHeldSheets sheets(cpu_settings());
    sheets.simulation().add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), btVector3(0, -1, 0));
    for (btSoftBody* body : {&sheets.lower, &sheets.upper}) body->m_cfg.collisions |= more_flags;
    const std::size_t whole = sheets.step().size();
    CuttingPlane plane;
    sheets.upper.refine(&plane, btScalar(0.001), /*cut=*/true);
    ASSERT_TRUE(sheets.lower.cutLink(40, 41, btScalar(0.4)));
    for (btSoftBody* body : {&sheets.lower, &sheets.upper}) sheets.hold(*body);
    EXPECT_GT(sheets.step().size(), whole);
    EXPECT_EQ(sheets.lower.m_fdbvt.empty(), more_flags == 0);
    EXPECT_EQ(sheets.lower.m_faceRigidContacts.size() > 0, more_flags != 0);
  }
}

}  // namespace
}  // namespace softcd::test
