// Edges against edges, which Bullet does not test: reports, and the response that is opted into.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "any_simulation.hpp"

namespace softcd::test {
namespace {

using bullet::EdgeContact;
using bullet::EdgeContacts;
using demo::PlugIn;
using demo::Simulation;

constexpr btScalar kEdgeMargin = btScalar(0.03);

/// A roof: two rows of large faces that meet in a ridge along x (or z) at `height`, and hang down from it (or stand up
/// from it). Its nodes are far from everything but the ridge's ends.
std::unique_ptr<btSoftBody> make_ridge(btSoftBodyWorldInfo& info, btScalar height, bool along_x, btScalar down,
                                       bool fixed) {
  demo::ClothShape shape;
  shape.columns = 2;
  shape.rows = 3;
  shape.position = [=](int column, int row) {
    const btScalar along = btScalar(column) - btScalar(0.5);
    const btScalar across = btScalar(0.4) * btScalar(row - 1);
    const btScalar y = height - down * btFabs(btScalar(row - 1));
    return along_x ? btVector3(along, y, across) : btVector3(across, y, along);
  };
  if (fixed) shape.is_fixed = [](int, int) { return true; };
  auto ridge = demo::make_cloth(info, shape, 1);
  ridge->getCollisionShape()->setMargin(kEdgeMargin);
  ridge->m_cfg.piterations = 10;
  return ridge;
}

/// A world for ridges, and a step in which its springs are stable.
struct RidgeWorld : AnySimulation {
  btScalar seconds;

  RidgeWorld(World world, const bullet::Settings& settings)
      : AnySimulation(world, settings, /*material=*/{200, 1, 20}), seconds(is_deformable(world) ? kStep / 8 : kStep) {}
  void step() { AnySimulation::step(seconds); }
  const std::vector<EdgeContact>& edge_contacts() { return detection().edge_contacts(); }
};

struct Ridges {
  btSoftBody* lower;
  btSoftBody* upper;

  explicit Ridges(RidgeWorld& simulation) {
    lower = &simulation.add(make_ridge(simulation.world_info(), 0, true, btScalar(0.5), true));
    upper = &simulation.add(make_ridge(simulation.world_info(), btScalar(0.2), false, btScalar(-0.5), false));
  }

  /// Returns the height of the upper ridge above the lower one, where they cross.
  btScalar gap() const { return (upper->m_nodes[2].m_x.y() + upper->m_nodes[3].m_x.y()) / 2; }
};

bullet::Settings settings_with(EdgeContacts edge_contacts, Detection detection = Detection::dcd) {
  bullet::Settings settings = test_settings(detection);
  settings.edge_contacts = edge_contacts;
  return settings;
}

void expect_the_crossing(const std::vector<EdgeContact>& contacts, const btSoftBody& lower, const btSoftBody& upper) {
  const auto found = std::find_if(contacts.begin(), contacts.end(), [&](const EdgeContact& contact) {
    return contact.a.body == &lower && contact.b.body == &upper && contact.a.nodes[0] == 2 && contact.a.nodes[1] == 3 &&
           contact.b.nodes[0] == 2 && contact.b.nodes[1] == 3;
  });
  ASSERT_NE(found, contacts.end());
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(found->a.weights[i], 0.5, 0.01);
    EXPECT_NEAR(found->b.weights[i], 0.5, 0.01);
  }
  EXPECT_NEAR(found->normal.y(), -1, 0.01) << "from the upper edge towards the lower one";
  EXPECT_LT(found->distance, 2 * kEdgeMargin + btScalar(1e-4));
}

void expect_ridges_to_rest(World world, const bullet::Settings& settings) {
  SCOPED_TRACE(name_of(world));
  RidgeWorld simulation(world, settings);
  const Ridges ridges(simulation);
  bool is_reported = false;
  for (btScalar time = 0; time < 1; time += simulation.seconds) {
    simulation.step();
    if (!simulation.edge_contacts().empty() && !is_reported) {
      is_reported = true;
      expect_the_crossing(simulation.edge_contacts(), *ridges.lower, *ridges.upper);
    }
  }
  EXPECT_TRUE(is_reported);
  EXPECT_NEAR(ridges.gap(), 2 * kEdgeMargin, 0.001);
}

class EdgeResponse : public testing::TestWithParam<Detection> {};
INSTANTIATE_TEST_SUITE_P(Detections, EdgeResponse, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& parameter) { return parameter.param == Detection::dcd ? "dcd" : "ccd"; });

TEST_P(EdgeResponse, crossed_ridges_rest_on_each_other) {
  const bullet::Settings settings = settings_with(EdgeContacts::respond, GetParam());
  for (const World world : {World::one_line, World::dispatcher, World::deformable}) {
    expect_ridges_to_rest(world, settings);
  }
}

TEST_P(EdgeResponse, crossed_ridges_rest_on_each_other_with_one_contact_for_each_nearest_place) {
  bullet::Settings settings = settings_with(EdgeContacts::respond, GetParam());
  settings.contacts = bullet::Contacts::closest_feature;
  expect_ridges_to_rest(World::one_line, settings);
}

/// How far the lower ridge moves in a step.
constexpr btScalar kPush = btScalar(0.025);

/// The upper ridge is fixed at one end, a thousandth of its length away from where the lower one, all of it fixed,
/// moves up against it: only a node with a weight of 0.001 there can give way. Returns how far the fastest node then
/// moves in a step.
btScalar fastest_beside_a_fixed_node(RidgeWorld&& simulation) {
  btSoftBody& lower = simulation.add(make_ridge(simulation.world_info(), 0, true, btScalar(0.5), true));
  auto ridge = make_ridge(simulation.world_info(), btScalar(0.08), false, btScalar(-0.5), false);
  ridge->translate(btVector3(0, 0, btScalar(0.499)));
  ridge->setMass(2, 0);
  const btSoftBody& upper = simulation.add(std::move(ridge));
  const btVector3 fixed_at = upper.m_nodes[2].m_x;
  btScalar fastest = 0;
  for (int i = 0; i < 5; ++i) {
    for (int n = 0; n < lower.m_nodes.size(); ++n) lower.m_nodes[n].m_v = btVector3(0, kPush / simulation.seconds, 0);
    simulation.step();
    for (int n = 0; n < upper.m_nodes.size(); ++n) fastest = btMax(fastest, upper.m_nodes[n].m_v.length());
  }
  EXPECT_EQ(upper.m_nodes[2].m_x, fixed_at);
  return fastest * simulation.seconds;
}

TEST_P(EdgeResponse, throws_no_node_that_has_a_small_share_in_a_contact) {
  for (const World world : {World::one_line, World::deformable}) {
    const bullet::Settings settings = settings_with(EdgeContacts::respond, GetParam());
    EXPECT_LT(fastest_beside_a_fixed_node(RidgeWorld(world, settings)), 2 * kPush) << name_of(world);
  }
}

TEST_P(EdgeResponse, leaves_fixed_nodes_where_they_are) {
  RidgeWorld simulation(World::one_line, settings_with(EdgeContacts::respond, GetParam()));
  const Ridges ridges(simulation);
  for (const int end : {0, 1, 3, 4, 5}) ridges.lower->setMass(end, btScalar(0.2));  // 2 stays fixed
  const btVector3 fixed_at = ridges.lower->m_nodes[2].m_x;
  std::size_t contact_count = 0;
  for (int step = 0; step < 30; ++step) {
    simulation.step();
    contact_count += simulation.edge_contacts().size();
  }
  EXPECT_GT(contact_count, 0U);
  EXPECT_EQ(ridges.lower->m_nodes[2].m_x, fixed_at);
}

/// Lets the upper ridge fall through the lower one. Returns whether that was reported.
bool fall_through(RidgeWorld&& simulation) {
  const Ridges ridges(simulation);
  bool is_reported = false;
  for (btScalar time = 0; time < btScalar(0.5); time += simulation.seconds) {
    simulation.step();
    const std::vector<EdgeContact>& contacts = simulation.edge_contacts();
    if (!is_reported && !contacts.empty()) expect_the_crossing(contacts, *ridges.lower, *ridges.upper);
    is_reported |= !contacts.empty();
  }
  EXPECT_LT(ridges.gap(), -0.2);
  return is_reported;
}

TEST(EdgeContacts, are_reported_of_ridges_that_pass_through_each_other_without_a_response) {
  for (const EdgeContacts edge_contacts : {EdgeContacts::off, EdgeContacts::report}) {
    for (const World world : {World::one_line, World::deformable}) {
      bullet::Settings settings = settings_with(edge_contacts, Detection::ccd);
      settings.untangle = bullet::Untangle::off;
      EXPECT_EQ(fall_through(RidgeWorld(world, settings)), edge_contacts == EdgeContacts::report) << name_of(world);
    }
  }
}

TEST(EdgeContacts, hold_ridges_by_default_in_deformable_worlds_only) {
  bullet::Settings settings;
  settings.backend = backend_under_test();
  for (const World world : {World::deformable, World::attached_deformable}) expect_ridges_to_rest(world, settings);
  for (const World world : {World::one_line, World::multi_body, World::dispatcher, World::attached}) {
    EXPECT_FALSE(fall_through(RidgeWorld(world, settings))) << name_of(world);
  }
}

TEST(EdgeContacts, stay_the_choice_of_the_world_if_settings_change) {
  for (const World world : {World::one_line, World::attached, World::deformable, World::attached_deformable}) {
    SCOPED_TRACE(name_of(world));
    const EdgeContacts choice = is_deformable(world) ? EdgeContacts::respond : EdgeContacts::off;
    bullet::Settings settings = cpu_settings();
    settings.edge_contacts = EdgeContacts::report;
    AnySimulation simulation(world, settings);
    EXPECT_EQ(simulation.detection().settings().edge_contacts, EdgeContacts::report);
    settings.edge_contacts = EdgeContacts::automatic;
    simulation.detection().set_settings(settings);
    EXPECT_EQ(simulation.detection().settings().edge_contacts, choice);
  }
}

struct MassPoint {
  btVector3 position{0, 0, 0}, velocity{0, 0, 0};
};

MassPoint center_of_mass(const std::vector<const btSoftBody*>& bodies) {
  MassPoint center;
  btScalar mass = 0;
  for (const btSoftBody* body : bodies) {
    for (int i = 0; i < body->m_nodes.size(); ++i) {
      const btSoftBody::Node& node = body->m_nodes[i];
      center.position += node.m_x / node.m_im;
      center.velocity += node.m_v / node.m_im;
      mass += 1 / node.m_im;
    }
  }
  center.position /= mass;
  center.velocity /= mass;
  return center;
}

// Bullet takes a body's velocities from its positions before the next body's contacts move it: positions are compared.
TEST_P(EdgeResponse, does_not_move_the_center_of_free_bodies_that_meet_off_their_middles) {
  RidgeWorld simulation(World::one_line, settings_with(EdgeContacts::respond, GetParam()));
  simulation.world_info().m_gravity.setZero();
  const auto add = [&](btScalar height, bool along_x, btScalar down) -> btSoftBody& {
    return simulation.add(make_ridge(simulation.world_info(), height, along_x, down, false));
  };
  btSoftBody& lower = add(0, true, btScalar(0.5));
  btSoftBody& upper = add(btScalar(0.1), false, btScalar(-0.5));
  upper.translate(btVector3(btScalar(0.3), 0, btScalar(0.2)));
  upper.setVelocity(btVector3(0, -1, 0));
  for (int step = 0; step < 30; ++step) {
    const MassPoint before = center_of_mass({&lower, &upper});
    simulation.step();
    const btVector3 moved = center_of_mass({&lower, &upper}).position - before.position;
    EXPECT_LT((moved - before.velocity * kStep).length(), 1e-5) << "of 0.008 in a step";
  }
  EXPECT_LT(center_of_mass({&lower}).velocity.y(), -0.3) << "they have met";
}

btVector3 momentum_of(const btSoftBody& body) {
  btVector3 sum(0, 0, 0);
  for (int i = 0; i < body.m_nodes.size(); ++i) sum += body.m_nodes[i].m_v / body.m_nodes[i].m_im;
  return sum;
}

// Bullet's response does not move anchored nodes and gives their body nothing, but would push the lower ridge.
TEST(EdgeContacts, of_anchored_nodes_push_nothing_without_the_opposite_push) {
  for (const World world : {World::deformable, World::attached_deformable}) {
    for (const int anchors : {1, 2}) {
      SCOPED_TRACE(name_of(world) + ", anchors: " + std::to_string(anchors));
      RidgeWorld simulation(world, settings_with(EdgeContacts::respond));
      simulation.set_gravity(btVector3(0, 0, 0));
      const btSoftBody& lower = simulation.add(make_ridge(simulation.world_info(), 0, true, btScalar(0.5), false));
      btSoftBody& upper =
          simulation.add(make_ridge(simulation.world_info(), btScalar(0.08), false, btScalar(-0.5), false));
      btRigidBody& box = simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), btVector3(0, 3, 0), 1);
      for (int i = 0; i < anchors; ++i) upper.appendDeformableAnchor(2 + i, &box);
      const btVector3 velocity(0, -1, 0);
      upper.setVelocity(velocity);
      box.setLinearVelocity(velocity);
      const auto momentum = [&] {
        return momentum_of(lower) + momentum_of(upper) + box.getLinearVelocity() / box.getInvMass();
      };
      const btVector3 before = momentum();
      bool is_reported = false;
      for (int i = 0; i < 40; ++i) {
        simulation.step();
        is_reported |= !simulation.edge_contacts().empty();
      }
      EXPECT_TRUE(is_reported);
      EXPECT_LT((momentum() - before).length(), btScalar(1e-3) * before.length());
    }
  }
}

TEST(EdgeContacts, are_found_within_a_body) {
  RidgeWorld simulation(World::deformable, settings_with(EdgeContacts::report));
  demo::ClothShape shape;
  shape.columns = 9;
  shape.rows = 3;
  // Folded over itself, twisted so that edges cross.
  shape.position = [](int column, int row) {
    const btScalar along = btScalar(0.1) * btScalar(column < 4 ? column : 8 - column);
    return btVector3(along + btScalar(0.03) * btScalar(row), btScalar(0.04) * (column < 4 ? 0 : 1),
                     btScalar(0.1) * btScalar(row) + btScalar(0.02) * btScalar(column));
  };
  auto strip = demo::make_cloth(simulation.world_info(), shape, 1);
  strip->getCollisionShape()->setMargin(btScalar(0.03));
  strip->setSelfCollision(true);
  const btSoftBody& body = simulation.add(std::move(strip));
  simulation.step();
  EXPECT_FALSE(simulation.edge_contacts().empty());
  for (const EdgeContact& contact : simulation.edge_contacts()) {
    EXPECT_EQ(contact.a.body, &body);
    EXPECT_EQ(contact.b.body, &body);
  }
}

/// A triangle whose side from (-1, height, 0) to (1, height + slope, 0), turned about y, is the only part near y = 0.
std::unique_ptr<btSoftBody> make_slanted_edge(btSoftBodyWorldInfo& info, btScalar height, btScalar slope,
                                              btScalar third, bool turned) {
  const auto place = [turned](btScalar x, btScalar y, btScalar z) {
    return turned ? btVector3(z, y, x) : btVector3(x, y, z);
  };
  const btVector3 corners[] = {place(-1, height, 0), place(1, height + slope, 0), place(0, third, btScalar(0.5))};
  auto body = std::make_unique<btSoftBody>(&info, 3, corners, nullptr);
  body->appendFace(0, 1, 2);
  body->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  body->m_cfg.piterations = 0;
  body->getCollisionShape()->setMargin(kEdgeMargin);
  return body;
}

// An edge may be slanted to the normal. One of its nodes then lies farther along the normal, and must stay so.
TEST(SlantedEdges, want_both_nodes_of_a_slanted_edge_as_far_away_as_its_point) {
  bullet::Settings settings = settings_with(EdgeContacts::respond);
  Simulation simulation(PlugIn::one_line_world, settings);
  simulation.world_info().m_gravity.setZero();
  simulation.add(make_slanted_edge(simulation.world_info(), 0, 0, -3, false)).setTotalMass(100);
  const btSoftBody& upper =
      simulation.add(make_slanted_edge(simulation.world_info(), btScalar(-0.15), btScalar(0.4), 3, true));
  simulation.step(kStep);
  ASSERT_EQ(upper.m_scontacts.size(), 2);
  const auto wanted = [&](int i) {
    const btSoftBody::SContact& contact = upper.m_scontacts[i];
    return contact.m_margin - contact.m_normal.dot(contact.m_node->m_x);
  };
  EXPECT_NE(upper.m_scontacts[0].m_margin, upper.m_scontacts[1].m_margin);
  EXPECT_NEAR(double(wanted(0)), double(wanted(1)), 1e-5);
}

}  // namespace
}  // namespace softcd::test
