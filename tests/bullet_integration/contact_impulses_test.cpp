// The impulses of body_contacts(), compared with the bodies' changes of momentum.

#include <gtest/gtest.h>

#include <array>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"
#include "BulletSoftBody/btSoftMultiBodyDynamicsWorld.h"
#include "any_simulation.hpp"
#include "contact_impulses.hpp"
#include "small_scenes.hpp"

namespace softcd::test {
namespace {

using bullet::BodyPairContacts;
using bullet::ReadOut;
using Pairs = std::vector<BodyPairContacts>;

class ContactImpulses : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ContactImpulses,
                         testing::Values(World::one_line, World::multi_body, World::deformable, World::attached,
                                         World::attached_deformable),
                         world_name);

class ClassicContactImpulses : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ClassicContactImpulses, testing::Values(World::one_line, World::multi_body),
                         world_name);

/// Makes a step, and expects that gravity and the contacts' impulses explain the change of each sheet's momentum.
/// Sheets have 1 kg. Returns the greatest impulse on a sheet, N s.
template <std::size_t kCount>
btScalar step_and_expect_momenta(AnySimulation& simulation, World world, btSoftBody* (&sheets)[kCount]) {
  const btScalar time = simulation.step_length();
  btVector3 before[kCount], start[kCount];
  for (std::size_t i = 0; i < kCount; ++i) {
    before[i] = momentum(*sheets[i], &btSoftBody::Node::m_v);
    start[i] = momentum(*sheets[i], &btSoftBody::Node::m_x);
  }
  simulation.step(time);
  const Pairs& pairs = simulation.detection().body_contacts();
  btScalar greatest = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const btVector3 given = given_to(*sheets[i], pairs);
    const btVector3 expected = before[i] + btVector3(0, -kGravity * time, 0) + given;
    EXPECT_NEAR(momentum_at_end(world, *sheets[i], start[i], time).distance(expected), 0, 3e-5)
        << "kg m/s, sheet " << i;
    greatest = btMax(greatest, given.length());
  }
  return greatest;
}

/// Two free sheets, of one kilogram each and not the same nodes, that fly towards each other and fall.
TEST_P(ContactImpulses, and_gravity_are_all_that_changes_the_momentum_of_free_bodies) {
  for (const bullet::EdgeContacts edges : {bullet::EdgeContacts::off, bullet::EdgeContacts::respond}) {
    AnySimulation simulation(GetParam(), reading_impulses(edges));
    btSoftBody* sheets[2];
    for (int i = 0; i < 2; ++i) {
      SheetOptions options;
      options.nodes_per_side = 6 + i;
      options.height = btScalar(0.15) * btScalar(i);
      sheets[i] = &simulation.add(make_sheet(simulation.world_info(), options));
      sheets[i]->setVelocity(btVector3(btScalar(0.3), i == 0 ? 1 : -1, 0));
      sheets[i]->m_cfg.kDF = btScalar(0.5);
    }
    btScalar greatest = 0;
    for (int step = 0; step < 30; ++step) {
      SCOPED_TRACE(step);
      greatest = btMax(greatest, step_and_expect_momenta(simulation, GetParam(), sheets));
    }
    EXPECT_GT(greatest, 0.1) << "they have met";
  }
}

// Three free sheets, of which the last pushes the second through the first after Bullet has solved both.
TEST_P(ClassicContactImpulses, of_a_pile_count_what_is_solved_late) {
  bullet::Settings settings = reading_impulses();
  settings.contacts = bullet::Contacts::closest_feature;
  AnySimulation simulation(GetParam(), settings);
  btSoftBody* sheets[3];
  for (int i = 0; i < 3; ++i) {
    SheetOptions options;
    options.nodes_per_side = 6 + i;
    options.height = btScalar(0.12) * btScalar(i);
    sheets[i] = &simulation.add(make_sheet(simulation.world_info(), options));
    sheets[i]->setVelocity(btVector3(0, 3 - 3 * btScalar(i), 0));
  }
  btScalar greatest = 0;
  for (int step = 0; step < 20; ++step) {
    SCOPED_TRACE(step);
    greatest = btMax(greatest, step_and_expect_momenta(simulation, GetParam(), sheets));
  }
  EXPECT_GT(greatest, 0.1) << "they have met";
}

// A sheet on a free box, and one thrown at it: what the nodes give the box counts as their contacts with it.
TEST(ContactImpulses, of_a_box_that_backs_nodes_are_what_all_get) {
  for (const World world : {World::deformable, World::attached_deformable}) {
    AnySimulation simulation(world, reading_impulses());
    simulation.set_gravity(btVector3(0, 0, 0));
    const btScalar half = btScalar(0.15);
    const btRigidBody& box =
        simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(half, half, half)), btVector3(0, -half, 0), 2);
    btSoftBody* sheets[2];
    for (int i = 0; i < 2; ++i) {
      SheetOptions options;
      options.nodes_per_side = 9;
      options.margin = btScalar(0.02);
      options.height = btScalar(0.01) + btScalar(0.04) * btScalar(i);
      sheets[i] = &simulation.add(make_sheet(simulation.world_info(), options));
    }
    sheets[1]->translate(btVector3(btScalar(0.03), 0, btScalar(0.02)));
    sheets[1]->setVelocity(btVector3(0, -3, 0));
    const btCollisionObject* const objects[3] = {&box, sheets[0], sheets[1]};
    const auto momenta = [&] {
      return std::array<btVector3, 3>{box.getLinearVelocity() / box.getInvMass(),
                                      momentum(*sheets[0], &btSoftBody::Node::m_v),
                                      momentum(*sheets[1], &btSoftBody::Node::m_v)};
    };
    btScalar greatest = 0, greatest_soft = 0;
    for (int step = 0; step < 20; ++step) {
      const std::array<btVector3, 3> before = momenta();
      simulation.step(simulation.step_length() / 4);
      const std::array<btVector3, 3> after = momenta();
      for (std::size_t i = 0; i < 3; ++i) {
        const btVector3 given = given_to(*objects[i], simulation.detection().body_contacts());
        EXPECT_NEAR((after[i] - before[i]).distance(given), 0, 3e-5) << "object " << i << " in step " << step;
        if (i == 0) greatest = btMax(greatest, given.length());
      }
      for (const BodyPairContacts& pair : simulation.detection().body_contacts()) {
        // Bullet's solver gives the two sides of contacts with rigid bodies different impulses.
        if (pair.b == &box) continue;
        EXPECT_NEAR((pair.impulse_a + pair.impulse_b).length(), 0, 1e-5) << "in step " << step;
        greatest_soft = btMax(greatest_soft, pair.impulse_a.length());
      }
    }
    EXPECT_GT(greatest, 0.1) << "the box was hit";
    EXPECT_GT(greatest_soft, 0.1) << "the sheets have met";
  }
}

TEST_P(ContactImpulses, are_what_a_rigid_body_gets) {
  AnySimulation simulation(GetParam(), reading_impulses());
  SheetOptions options;
  options.fixed = true;
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  // Held at its border.
  for (int i = 0; i < sheet.m_nodes.size(); ++i) {
    const btVector3& x = sheet.m_nodes[i].m_x;
    if (btMax(btFabs(x.x()), btFabs(x.z())) < btScalar(0.45)) sheet.setMass(i, btScalar(0.02));
  }
  btRigidBody& box =
      simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2))),
                           btVector3(0, btScalar(0.2), 0), btScalar(0.5));
  box.setLinearVelocity(btVector3(0, -2, 0));
  const btScalar time = simulation.step_length();
  btScalar greatest = 0;
  for (int step = 0; step < 40; ++step) {
    const btVector3 before = box.getLinearVelocity() / box.getInvMass();
    simulation.step(time);
    const btVector3 given = given_to(box, simulation.detection().body_contacts());
    const btVector3 expected = before + btVector3(0, -kGravity * time / 2, 0) + given;
    EXPECT_NEAR((box.getLinearVelocity() / box.getInvMass()).distance(expected), 0, 2e-6) << "in step " << step;
    greatest = btMax(greatest, given.length());
  }
  EXPECT_GT(greatest, 0.02);
}

/// Bullet's classic solver gives a link half the length of what a node gets, along the normal.
TEST(ContactImpulses, are_what_a_link_gets) {
  AnySimulation simulation(World::multi_body, reading_impulses());
  SheetOptions options;
  options.fixed = true;
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  for (int i = 0; i < sheet.m_nodes.size(); ++i) {
    const btVector3& x = sheet.m_nodes[i].m_x;
    if (btMax(btFabs(x.x()), btFabs(x.z())) < btScalar(0.45)) sheet.setMass(i, btScalar(0.02));
  }
  constexpr btScalar kMass = btScalar(0.5);
  btBoxShape shape(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2)));
  btVector3 inertia;
  shape.calculateLocalInertia(kMass, inertia);
  btMultiBody body(0, kMass, inertia, /*fixedBase=*/false, /*canSleep=*/false);
  body.setBasePos(btVector3(0, btScalar(0.2), 0));
  body.setLinearDamping(0);
  body.finalizeMultiDof();
  btMultiBodyLinkCollider collider(&body, -1);
  collider.setCollisionShape(&shape);
  collider.setWorldTransform(body.getBaseWorldTransform());
  body.setBaseCollider(&collider);
  auto& world = dynamic_cast<btSoftMultiBodyDynamicsWorld&>(simulation.world());
  world.addCollisionObject(&collider);
  world.addMultiBody(&body);
  body.setBaseVel(btVector3(0, -2, 0));
  btScalar greatest = 0;
  for (int step = 0; step < 40; ++step) {
    const btVector3 before = body.getBaseVel() * kMass;
    world.stepSimulation(kStep, 0);
    const btVector3 given = given_to(collider, simulation.detection().body_contacts());
    const btVector3 expected = before + btVector3(0, -kGravity * kStep * kMass, 0) + given;
    EXPECT_NEAR((body.getBaseVel() * kMass).distance(expected), 0, 1e-5) << "in step " << step;
    greatest = btMax(greatest, given.length());
  }
  EXPECT_GT(greatest, 0.02);
  world.removeMultiBody(&body);
  world.removeCollisionObject(&collider);
}

/// A free sheet that falls onto the corner of a box.
TEST_P(ContactImpulses, of_a_rigid_object_are_what_the_soft_body_gets) {
  AnySimulation simulation(GetParam(), reading_impulses());
  simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))),
                       btVector3(btScalar(0.3), btScalar(-0.5), btScalar(0.3)));
  SheetOptions options;
  options.height = btScalar(0.1);
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  const btScalar time = simulation.step_length();
  btScalar greatest = 0, worst = 0;
  for (int step = 0; step < 60; ++step) {
    const btVector3 before = momentum(sheet, &btSoftBody::Node::m_v);
    const btVector3 start = momentum(sheet, &btSoftBody::Node::m_x);
    simulation.step(time);
    const btVector3 given = given_to(sheet, simulation.detection().body_contacts());
    const btVector3 expected = before + btVector3(0, -kGravity * time, 0) + given;
    const btScalar difference = momentum_at_end(GetParam(), sheet, start, time).distance(expected);
    worst = btMax(worst, difference);
    greatest = btMax(greatest, given.length());
  }
  EXPECT_GT(greatest, 0.1);
  EXPECT_LT(worst, btScalar(3e-5));
}

/// Bullet does so after the contacts of the step are known, and solves none of them.
TEST(ContactImpulses, of_a_body_that_falls_asleep_within_a_step_stay) {
  for (const World world : {World::deformable, World::attached_deformable}) {
    AnySimulation simulation(world, reading_impulses());
    simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, btScalar(0.5), 1)), btVector3(0, btScalar(-0.5), 0));
    SheetOptions options;
    options.height = btScalar(0.06);
    btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
    for (int step = 0; step < 20; ++step) simulation.step_once();
    ASSERT_EQ(simulation.detection().body_contacts().size(), 1U);
    const btVector3 before = simulation.detection().body_contacts()[0].impulse_a;
    EXPECT_GT(before.y(), 0);
    sheet.setActivationState(WANTS_DEACTIVATION);
    for (int step = 0; step < 3; ++step) {
      simulation.step_once();
      EXPECT_FALSE(sheet.isActive());
      const Pairs& pairs = simulation.detection().body_contacts();
      ASSERT_EQ(pairs.size(), 1U);
      EXPECT_TRUE(pairs[0].has_impulses);
      EXPECT_EQ(pairs[0].impulse_a, before);
    }
  }
}

TEST_P(ClassicContactImpulses, of_a_node_that_is_pushed_out_of_a_fixed_face_are_what_bullets_formula_gives) {
  AnySimulation simulation(GetParam(), reading_impulses());
  simulation.world_info().m_gravity.setZero();
  const btVector3 corners[3] = {btVector3(-1, 0, -1), btVector3(2, 0, -1), btVector3(-1, 0, 2)};
  auto triangle = std::make_unique<btSoftBody>(&simulation.world_info(), 3, corners, nullptr);
  triangle->appendFace(0, 1, 2);
  for (int i = 0; i < 3; ++i) triangle->setMass(i, 0);
  triangle->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  triangle->getCollisionShape()->setMargin(btScalar(0.05));
  simulation.add(std::move(triangle));
  const btVector3 x(btScalar(0.2), btScalar(0.07), btScalar(0.1));
  auto grain = std::make_unique<btSoftBody>(&simulation.world_info(), 1, &x, nullptr);
  grain->setTotalMass(2);
  grain->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  grain->m_cfg.kDF = 0;
  grain->m_cfg.piterations = 1;
  grain->getCollisionShape()->setMargin(btScalar(0.05));
  grain->setVelocity(btVector3(0, btScalar(-0.06), 0));
  simulation.add(std::move(grain));
  simulation.step();
  const Pairs& pairs = simulation.detection().body_contacts();
  ASSERT_EQ(pairs.size(), 1U);
  ASSERT_EQ(pairs[0].contacts.size(), 1U);
  // 1 mm deeper at the step's end, with a margin of 0.1 that Bullet lets grow by twice that.
  const btScalar depth = btScalar(0.1 + 0.002 - 0.069);
  EXPECT_NEAR(pairs[0].contacts[0].depth, depth, 1e-5);
  EXPECT_NEAR(pairs[0].impulse_b.y(), 2 * depth / kStep, 1e-3);
  EXPECT_EQ(pairs[0].impulse_a, btVector3(0, 0, 0)) << "a fixed body is given nothing";
}

/// Two sheets, one of them hanging on a box that falls onto the other.
std::vector<btScalar> end_of_busy_scene(World world, ReadOut read_out, Detection detection) {
  bullet::Settings settings = reading_impulses();
  settings.read_out = read_out;
  settings.detection = detection;
  settings.convex_shapes = bullet::ConvexShapes::faces_and_edges;
  AnySimulation simulation(world, settings);
  SheetOptions options;
  options.fixed = true;
  btSoftBody& held = simulation.add(make_sheet(simulation.world_info(), options));
  for (int i = 20; i < 60; ++i) held.setMass(i, btScalar(0.01));
  btRigidBody& box =
      simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1))),
                           btVector3(0, btScalar(0.4), 0), 1);
  options.fixed = false;
  options.height = btScalar(0.25);
  btSoftBody& hanging = simulation.add(make_sheet(simulation.world_info(), options));
  if (world != World::deformable) {
    hanging.appendAnchor(40, &box);
    hanging.m_cfg.viterations = 1;
    hanging.m_cfg.diterations = 1;
  }
  for (int step = 0; step < 40; ++step) simulation.step();
  std::vector<btScalar> end = coordinates_of(held);
  append(end, coordinates_of(hanging));
  const btVector3& center = box.getWorldTransform().getOrigin();
  const btVector3& turn = box.getAngularVelocity();
  append(end, {center.x(), center.y(), center.z(), turn.x(), turn.y(), turn.z()});
  return end;
}

TEST(ContactImpulses, leave_no_trace_in_classic_worlds) {
  for (const World world : {World::one_line, World::multi_body}) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      EXPECT_EQ(end_of_busy_scene(world, ReadOut::impulses, detection),
                end_of_busy_scene(world, ReadOut::off, detection));
    }
  }
}

TEST(ContactImpulses, are_not_known_where_the_solver_is_not_seen) {
  AnySimulation simulation(World::dispatcher, reading_impulses());
  SheetOptions options;
  for (const btScalar height : {btScalar(0), btScalar(0.08)}) {
    options.height = height;
    simulation.add(make_sheet(simulation.world_info(), options));
  }
  simulation.step();
  const Pairs& pairs = simulation.detection().body_contacts();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_FALSE(pairs[0].has_impulses);
  EXPECT_EQ(pairs[0].impulse_a, btVector3(0, 0, 0));
}

TEST(ContactImpulses, are_not_known_of_bodies_that_something_else_moved) {
  AnySimulation simulation(World::one_line, reading_impulses());
  SheetOptions options;
  btSoftBody* sheets[4];
  for (int i = 0; i < 4; ++i) {
    // Two pairs, far from each other.
    const int pair = i / 2;
    options.height = btScalar(0.08) * btScalar(i % 2) + 5 * btScalar(pair);
    sheets[i] = &simulation.add(make_sheet(simulation.world_info(), options));
  }
  // Called before the soft bodies are solved.
  simulation.world().setInternalTickCallback(
      [](btDynamicsWorld* world, btScalar) {
        auto* sheet = static_cast<btSoftBody*>(world->getWorldUserInfo());
        sheet->m_nodes[3].m_x += btVector3(btScalar(0.001), 0, 0);
      },
      sheets[0]);
  simulation.step();
  const Pairs& pairs = simulation.detection().body_contacts();
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].a, sheets[0]);
  EXPECT_FALSE(pairs[0].has_impulses);
  EXPECT_EQ(pairs[0].impulse_a, btVector3(0, 0, 0));
  EXPECT_TRUE(pairs[1].has_impulses);
}

}  // namespace
}  // namespace softcd::test
