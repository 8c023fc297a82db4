// Soft bodies of links without faces: against each other, themselves, cloths and rigid meshes, in all kinds of world.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"
#include "mesh_tools/exact_intersection.hpp"
#include "scenes/vectors.hpp"

namespace softcd::test {
namespace {

using bullet::EdgeContact;
using bullet::EdgeContacts;

constexpr btScalar kMargin = btScalar(0.03);

bullet::Settings rope_settings(Detection detection, EdgeContacts edge_contacts = EdgeContacts::respond) {
  bullet::Settings settings = test_settings(detection);
  settings.edge_contacts = edge_contacts;
  return settings;
}

/// Half a kilogram.
std::unique_ptr<btSoftBody> make_rope(btSoftBodyWorldInfo& info, int links,
                                      const std::function<btVector3(btScalar)>& position, bool fixed_ends = false) {
  std::vector<btVector3> nodes;
  for (int i = 0; i <= links; ++i) nodes.push_back(position(btScalar(i) / btScalar(links)));
  auto rope = std::make_unique<btSoftBody>(&info, links + 1, nodes.data(), nullptr);
  for (int i = 0; i < links; ++i) rope->appendLink(i, i + 1);
  rope->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  rope->m_cfg.piterations = 10;
  rope->m_cfg.kDP = btScalar(0.02);
  rope->getCollisionShape()->setMargin(kMargin);
  rope->setTotalMass(btScalar(0.5));
  if (fixed_ends) {
    rope->setMass(0, 0);
    rope->setMass(links, 0);
  }
  return rope;
}

std::unique_ptr<btSoftBody> straight_rope(btSoftBodyWorldInfo& info, int links, const btVector3& from,
                                          const btVector3& to, bool fixed_ends = false) {
  return make_rope(
      info, links, [&](btScalar t) { return from.lerp(to, t); }, fixed_ends);
}

/// Returns the point at which the rope passes through the plane x = 0, or z = 0; nullopt if it does not.
std::optional<btVector3> crossing(const btSoftBody& rope, int axis) {
  for (int i = 0; i < rope.m_links.size(); ++i) {
    const btVector3& p = rope.m_links[i].m_n[0]->m_x;
    const btVector3& q = rope.m_links[i].m_n[1]->m_x;
    if (p[axis] * q[axis] <= 0 && p[axis] != q[axis]) return p.lerp(q, p[axis] / (p[axis] - q[axis]));
  }
  return std::nullopt;
}

class Ropes : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, Ropes, kWorldsOfRun, world_name);

/// Two ropes of seven links, the middle ones across each other, of which the upper one falls, or is thrown, upon the
/// lower one. The least height of the upper one above the lower one in so many steps, before its ends have swung round.
btScalar least_gap(World world, const bullet::Settings& settings, btScalar speed, int steps) {
  AnySimulation simulation(world, settings);
  const btSoftBody& lower =
      simulation.add(straight_rope(simulation.world_info(), 7, btVector3(-1, 0, 0), btVector3(1, 0, 0), true));
  btSoftBody& upper = simulation.add(
      straight_rope(simulation.world_info(), 7, btVector3(0, btScalar(0.3), -1), btVector3(0, btScalar(0.3), 1)));
  upper.setVelocity(btVector3(0, -speed, 0));
  btScalar gap = BT_LARGE_FLOAT;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const std::optional<btVector3> below = crossing(lower, 0);
    const std::optional<btVector3> above = crossing(upper, 2);
    if (below && above) gap = btMin(gap, above->y() - below->y());
  }
  return gap;
}

TEST_P(Ropes, lie_across_each_other) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    EXPECT_GT(least_gap(GetParam(), rope_settings(detection), 2, 20), 0);
    EXPECT_LT(least_gap(GetParam(), rope_settings(detection, EdgeContacts::off), 2, 20), -0.1);
  }
}

TEST_P(Ropes, hang_over_the_border_of_a_cloth) {
  for (const EdgeContacts edge_contacts : {EdgeContacts::respond, EdgeContacts::off}) {
    AnySimulation simulation(GetParam(), rope_settings(Detection::ccd, edge_contacts));
    // One face as tall as a door: its upper border is far from all nodes.
    demo::ClothShape shape;
    shape.columns = shape.rows = 2;
    shape.position = [](int column, int row) { return btVector3(2 * btScalar(column) - 1, -2 * btScalar(row), 0); };
    shape.is_fixed = [](int, int) { return true; };
    auto door = demo::make_cloth(simulation.world_info(), shape, 1);
    door->getCollisionShape()->setMargin(kMargin);
    simulation.add(std::move(door));
    const btSoftBody& rope =
        simulation.add(straight_rope(simulation.world_info(), 5, btVector3(btScalar(0.1), btScalar(0.1), -1),
                                     btVector3(btScalar(0.1), btScalar(0.1), 1)));
    btScalar lowest = 1;
    for (int step = 0; step < 25; ++step) {
      simulation.step();
      lowest = btMin(lowest, crossing(rope, 2).value_or(btVector3(0, 1, 0)).y());
    }
    if (edge_contacts == EdgeContacts::respond) {
      EXPECT_GT(lowest, 0);
    } else {
      EXPECT_LT(lowest, -0.2);
    }
  }
}

/// A roof with its ridge along x, at height 0, as a rigid triangle mesh.
std::unique_ptr<btTriangleMesh> roof() {
  auto mesh = std::make_unique<btTriangleMesh>();
  for (const btScalar side : {btScalar(-1), btScalar(1)}) {
    const btVector3 low[] = {{-1, -2, side * btScalar(0.5)}, {1, -2, side * btScalar(0.5)}};
    mesh->addTriangle(low[0], low[1], btVector3(1, 0, 0));
    mesh->addTriangle(low[0], btVector3(1, 0, 0), btVector3(-1, 0, 0));
  }
  return mesh;
}

// A contact at an end of a link is its node's, and an anchored node has none.
TEST(AnchoredRopes, are_not_pushed_off_the_edges_at_their_anchors) {
  const std::unique_ptr<btTriangleMesh> mesh = roof();
  for (const bool is_anchored : {false, true}) {
    AnySimulation simulation(World::one_line, rope_settings(Detection::dcd));
    simulation.set_gravity(btVector3(0, 0, 0));
    auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
    shape->setMargin(kMargin);
    simulation.add_rigid(std::move(shape), btVector3(0, 0, 0));
    btRigidBody& holder = simulation.add_rigid(std::make_unique<btSphereShape>(kMargin), btVector3(3, 0, 0));
    btSoftBody& rope = simulation.add(straight_rope(simulation.world_info(), 3, btVector3(btScalar(0.1), kMargin, 0),
                                                    btVector3(btScalar(0.1), 1, 0)));
    if (is_anchored) rope.appendAnchor(0, &holder);
    simulation.step();
    EXPECT_EQ(AnySimulation::count_contacts(rope), is_anchored ? 0 : 1);
  }
}

TEST_P(Ropes, hang_over_the_edge_of_a_rigid_mesh) {
  const std::unique_ptr<btTriangleMesh> mesh = roof();
  for (const EdgeContacts edge_contacts : {EdgeContacts::respond, EdgeContacts::off}) {
    AnySimulation simulation(GetParam(), rope_settings(Detection::dcd, edge_contacts));
    auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
    shape->setMargin(kMargin);
    simulation.add_rigid(std::move(shape), btVector3(0, 0, 0));
    btSoftBody& rope =
        simulation.add(straight_rope(simulation.world_info(), 5, btVector3(btScalar(0.1), btScalar(0.1), -1),
                                     btVector3(btScalar(0.1), btScalar(0.1), 1)));
    bool has_touched = false;
    btScalar lowest = 1;
    for (int step = 0; step < 25; ++step) {
      simulation.step();
      has_touched |= AnySimulation::count_contacts(rope) > 0;
      lowest = btMin(lowest, crossing(rope, 2).value_or(btVector3(0, 1, 0)).y());
    }
    if (edge_contacts == EdgeContacts::respond) {
      EXPECT_TRUE(has_touched);
      EXPECT_GT(lowest, kMargin / 2);
    } else if (GetParam() == World::dispatcher) {
      EXPECT_LT(lowest, -0.05) << "nothing holds it";
    } else {
      EXPECT_GE(lowest, 0) << "the last pass holds it, without a margin";
    }
    EXPECT_LT(rope.m_nodes[0].m_x.y(), -0.1) << "its ends hang down";
  }
}

TEST_P(Ropes, touch_themselves) {
  AnySimulation simulation(GetParam(), rope_settings(Detection::dcd));
  // An eight that lies across itself.
  const auto eight = [](btScalar t) {
    const btScalar angle = btScalar(4.2) * t - btScalar(0.5);
    return btVector3(btSin(angle), btScalar(0.06) * t, btSin(angle) * btCos(angle));
  };
  auto made = make_rope(simulation.world_info(), 25, eight, true);
  made->setSelfCollision(true);
  const btSoftBody& rope = simulation.add(std::move(made));
  std::size_t count = 0;
  for (int step = 0; step < 30; ++step) {
    simulation.step();
    for (const EdgeContact& contact : simulation.detection().edge_contacts()) {
      EXPECT_EQ(contact.a.body, &rope);
      EXPECT_EQ(contact.b.body, &rope);
      EXPECT_GT(std::abs(contact.a.nodes[0] - contact.b.nodes[0]), 1);
      ++count;
    }
  }
  EXPECT_GT(count, 0U);
}

/// Links of the rope that go through faces of the cloth.
int count_intersections(const btSoftBody& rope, const btSoftBody& cloth) {
  const auto point = [](const btSoftBody::Node* node) { return demo::to_vec3d(node->m_x); };
  int count = 0;
  for (int i = 0; i < rope.m_links.size(); ++i) {
    for (int f = 0; f < cloth.m_faces.size(); ++f) {
      const btSoftBody::Face& face = cloth.m_faces[f];
      const std::array<Vec3d, 3> corners = {point(face.m_n[0]), point(face.m_n[1]), point(face.m_n[2])};
      count += mesh_tools::intersects(point(rope.m_links[i].m_n[0]), point(rope.m_links[i].m_n[1]), corners) ? 1 : 0;
    }
  }
  return count;
}

TEST_P(Ropes, thrown_at_a_cloth_do_not_pass_through_it) {
  if (GetParam() == World::dispatcher) GTEST_SKIP() << "which does not prevent crossings";
  for (const btScalar speed : {btScalar(5), btScalar(40)}) {
    AnySimulation simulation(GetParam(), rope_settings(Detection::ccd));
    SheetOptions options;
    options.margin = kMargin;
    options.nodes_per_side = 5;
    auto made = make_sheet(simulation.world_info(), options);
    for (const int corner : {0, 4, 20, 24}) made->setMass(corner, 0);
    const btSoftBody& cloth = simulation.add(std::move(made));
    const auto waves = [](btScalar t) {
      return btVector3(btScalar(1.6) * (t - btScalar(0.5)), btScalar(0.3) + btScalar(0.1) * btSin(20 * t),
                       btScalar(0.4) * btSin(9 * t));
    };
    btSoftBody& rope = simulation.add(make_rope(simulation.world_info(), 24, waves));
    rope.setVelocity(btVector3(0, -speed, 0));
    int met = 0;
    for (int step = 0; step < 30; ++step) {
      simulation.step();
      EXPECT_EQ(count_intersections(rope, cloth), 0) << "step " << step << " at " << speed;
      met += simulation.detection().edge_contacts().empty() ? 0 : 1;
    }
    EXPECT_GT(met, 0);
  }
}

TEST_P(Ropes, through_a_cloth_when_a_step_begins_are_let_go) {
  if (GetParam() == World::dispatcher) GTEST_SKIP() << "which does not prevent crossings";
  AnySimulation simulation(GetParam(), rope_settings(Detection::ccd));
  simulation.world_info().m_gravity.setZero();
  SheetOptions options;
  options.fixed = true;
  options.margin = btScalar(0.01);
  options.nodes_per_side = 6;
  const btSoftBody& cloth = simulation.add(make_sheet(simulation.world_info(), options));
  btSoftBody& rope = simulation.add(straight_rope(simulation.world_info(), 3, btVector3(0, btScalar(-0.6), 0),
                                                  btVector3(btScalar(0.05), btScalar(0.6), 0)));
  rope.getCollisionShape()->setMargin(btScalar(0.01));
  ASSERT_EQ(count_intersections(rope, cloth), 1);
  rope.setVelocity(btVector3(3, 0, 0));
  std::uint64_t excepted = 0;
  for (int step = 0; step < 20; ++step) {
    simulation.step();
    excepted += simulation.detection().crossing_answers().excepted;
  }
  // The deformable world's contacts stop it before.
  EXPECT_TRUE(excepted > 0 || is_deformable(GetParam()));
  EXPECT_GT(rope.m_nodes[0].m_x.x(), 0.05) << "it is not held where it was";
}

TEST_P(Ropes, are_read_out_with_what_they_give_each_other) {
  if (GetParam() == World::dispatcher) GTEST_SKIP() << "which does not see Bullet's solver";
  bullet::Settings settings = rope_settings(Detection::dcd);
  settings.read_out = bullet::ReadOut::impulses;
  std::vector<bullet::BodyPairContacts> read;
  settings.on_contacts = [&](const std::vector<bullet::BodyPairContacts>& pairs) {
    read.insert(read.end(), pairs.begin(), pairs.end());
  };
  AnySimulation simulation(GetParam(), settings);
  simulation.world_info().m_gravity.setZero();
  const auto add = [&](btScalar height, const btVector3& along) -> btSoftBody& {
    return simulation.add(straight_rope(simulation.world_info(), 7, btVector3(0, height, 0) - along,
                                        btVector3(btScalar(0.03), height, 0) + along));
  };
  btSoftBody& lower = add(0, btVector3(1, 0, 0));
  btSoftBody& upper = add(btScalar(0.1), btVector3(0, 0, 1));
  upper.setVelocity(btVector3(0, -1, 0));
  for (int step = 0; step < 20; ++step) simulation.step();
  btVector3 given(0, 0, 0);
  bool has_impulses = true;
  for (const bullet::BodyPairContacts& pair : read) {
    EXPECT_EQ(pair.a, &lower);
    EXPECT_EQ(pair.b, &upper);
    has_impulses &= pair.has_impulses || pair.contacts.empty();
    for (const bullet::BodyContact& contact : pair.contacts) {
      EXPECT_EQ(contact.a.feature, bullet::ContactSide::Feature::edge);
      EXPECT_EQ(contact.b.feature, bullet::ContactSide::Feature::edge);
      EXPECT_LT((contact.impulse_a + contact.impulse_b).length(), 1e-4);
      given += contact.impulse_a;
    }
  }
  EXPECT_FALSE(read.empty());
  EXPECT_TRUE(has_impulses);
  EXPECT_LT(given.y(), -0.01) << "the lower one is pushed down";
}

TEST(RopesWithoutEdgeContacts, are_tested_only_if_a_body_has_faces) {
  demo::Simulation simulation(demo::PlugIn::one_line_world, rope_settings(Detection::dcd, EdgeContacts::off));
  simulation.world_info().m_gravity.setZero();
  simulation.add(straight_rope(simulation.world_info(), 7, btVector3(-1, 0, 0), btVector3(1, 0, 0)));
  simulation.add(
      straight_rope(simulation.world_info(), 7, btVector3(0, btScalar(0.02), -1), btVector3(0, btScalar(0.02), 1)));
  const auto active_features = [&] {
    simulation.step(kStep);
    return simulation.detection()->contact_report().statistics().active_triangles;
  };
  EXPECT_EQ(active_features(), 0U);
  SheetOptions sheet;
  sheet.height = btScalar(-0.02);
  simulation.add(make_sheet(simulation.world_info(), sheet));
  EXPECT_GT(active_features(), 0U);
}

TEST(RopeTopology, is_followed_in_every_step) {
  demo::Simulation simulation(demo::PlugIn::one_line_world, rope_settings(Detection::dcd, EdgeContacts::report));
  simulation.world_info().m_gravity.setZero();
  btSoftBody& lower =
      simulation.add(straight_rope(simulation.world_info(), 7, btVector3(-1, 0, 0), btVector3(1, 0, 0), true));
  simulation.add(straight_rope(simulation.world_info(), 7, btVector3(0, btScalar(0.02), -1),
                               btVector3(0, btScalar(0.02), 1), true));
  const auto contacts = [&] {
    simulation.step(kStep);
    return simulation.detection()->edge_contacts();
  };
  ASSERT_EQ(contacts().size(), 1U);
  EXPECT_EQ(contacts()[0].a.nodes[0], 3);
  EXPECT_EQ(contacts()[0].a.nodes[1], 4);
  // The nodes get another place in memory.
  for (int i = 0; i < 50; ++i) lower.appendNode(btVector3(5, 5, btScalar(i)), 1);
  EXPECT_EQ(contacts().size(), 1U);
  lower.generateBendingConstraints(2);
  EXPECT_EQ(contacts().size(), 1U) << "bending links are no segments";
  // The middle link is cut.
  btSwap(lower.m_links[3], lower.m_links[lower.m_links.size() - 1]);
  lower.m_links.pop_back();
  EXPECT_EQ(contacts().size(), 0U);
  lower.appendLink(4, 3);
  EXPECT_EQ(contacts().size(), 1U);
  lower.appendLink(3, 4);
  EXPECT_EQ(contacts().size(), 1U) << "the same link twice";
  lower.appendFace(0, 1, 2);
  EXPECT_EQ(contacts().size(), 0U) << "links of a body with faces are none";
}

TEST(RopeTopology, with_nodes_of_another_body_is_an_error_that_names_the_segment) {
  bullet::Settings settings = rope_settings(Detection::dcd);
  settings.on_error = bullet::OnError::throw_error;
  demo::Simulation simulation(demo::PlugIn::one_line_world, settings);
  btSoftBody& rope = simulation.add(straight_rope(simulation.world_info(), 3, btVector3(-1, 0, 0), btVector3(1, 0, 0)));
  const btSoftBody& other =
      simulation.add(straight_rope(simulation.world_info(), 3, btVector3(-1, 1, 0), btVector3(1, 1, 0)));
  btSoftBody::Node* const own = rope.m_links[2].m_n[1];
  rope.m_links[2].m_n[1] = const_cast<btSoftBody::Node*>(&other.m_nodes[0]);
  try {
    simulation.step(kStep);
    ADD_FAILURE() << "no exception";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("segment 2"), std::string::npos) << error.what();
  }
  rope.m_links[2].m_n[1] = own;
  simulation.step(kStep);
}

}  // namespace
}  // namespace softcd::test
