// Contacts by pairs of bodies: WorldDetection::body_contacts() in all kinds of world.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"
#include "exact_contacts.hpp"

namespace softcd::test {
namespace {

using bullet::BodyContact;
using bullet::BodyPairContacts;
using bullet::ContactSide;
using bullet::ReadOut;
using Pairs = std::vector<BodyPairContacts>;
using State = BodyPairContacts::State;

bullet::Settings reading(ReadOut read_out = ReadOut::contacts, Detection detection = Detection::dcd) {
  bullet::Settings settings = test_settings(detection);
  settings.read_out = read_out;
  return settings;
}

class BodyContacts : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, BodyContacts, kWorldsOfRun, world_name);

class ClassicBodyContacts : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ClassicBodyContacts,
                         testing::Values(World::one_line, World::multi_body, World::dispatcher), world_name);

/// Returns null if the pair has no contacts.
const BodyPairContacts* find(const Pairs& pairs, const btCollisionObject& a, const btCollisionObject& b) {
  const auto found = std::find_if(pairs.begin(), pairs.end(), [&](const BodyPairContacts& pair) {
    return (pair.a == &a && pair.b == &b) || (pair.a == &b && pair.b == &a);
  });
  return found != pairs.end() ? &*found : nullptr;
}

/// One triangle, a metre and a half wide, whose centre is above the origin.
std::unique_ptr<btSoftBody> make_level_triangle(btSoftBodyWorldInfo& info, btScalar height, bool fixed) {
  const btScalar x[] = {-1, height, -1, 2, height, -1, -1, height, 2};
  btVector3 nodes[3];
  for (int i = 0; i < 3; ++i) nodes[i].setValue(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
  auto body = std::make_unique<btSoftBody>(&info, 3, nodes, nullptr);
  body->appendFace(0, 1, 2);
  for (int i = 0; i < 3; ++i) body->appendLink(i, (i + 1) % 3);
  body->setTotalMass(1);
  for (int i = 0; fixed && i < 3; ++i) body->setMass(i, 0);
  body->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  body->getCollisionShape()->setMargin(btScalar(0.05));
  return body;
}

/// One that points down, so that its first node is `gap` above the centre of the other.
std::unique_ptr<btSoftBody> make_pointing_triangle(btSoftBodyWorldInfo& info, btScalar gap) {
  auto body = make_level_triangle(info, 0, false);
  body->m_nodes[0].m_x.setValue(0, gap, 0);
  body->m_nodes[1].m_x.setValue(1, gap + 1, 0);
  body->m_nodes[2].m_x.setValue(0, gap + 1, 1);
  for (int i = 0; i < 3; ++i) body->m_nodes[i].m_q = body->m_nodes[i].m_x;
  body->resetLinkRestLengths();
  return body;
}

btVector3 weighted(const btSoftBody& body, const ContactSide& side) {
  btVector3 point(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    if (side.nodes[i] >= 0) point += side.weights[i] * body.m_nodes[side.nodes[i]].m_x;
  }
  return point;
}

TEST_P(BodyContacts, have_the_node_the_face_and_where_they_touch) {
  for (const bool node_comes_first : {false, true}) {
    AnySimulation simulation(GetParam(), reading());
    simulation.world().setGravity(btVector3(0, 0, 0));
    simulation.world_info().m_gravity.setZero();
    btSoftBody* node_body = nullptr;
    if (node_comes_first) node_body = &simulation.add(make_pointing_triangle(simulation.world_info(), btScalar(0.06)));
    btSoftBody& face_body = simulation.add(make_level_triangle(simulation.world_info(), 0, true));
    if (!node_comes_first) node_body = &simulation.add(make_pointing_triangle(simulation.world_info(), btScalar(0.06)));
    node_body->m_cfg.piterations = 0;
    EXPECT_TRUE(simulation.detection().body_contacts().empty()) << "before the first step";
    simulation.world().stepSimulation(btScalar(1e-5), 0);

    const Pairs& pairs = simulation.detection().body_contacts();
    ASSERT_EQ(pairs.size(), 1U);
    EXPECT_EQ(pairs[0].state, State::begun);
    EXPECT_EQ(pairs[0].a, node_comes_first ? node_body : &face_body);
    EXPECT_EQ(pairs[0].b, node_comes_first ? &face_body : node_body);
    EXPECT_TRUE(pairs[0].ended.empty());
    ASSERT_EQ(pairs[0].contacts.size(), 1U);
    const BodyContact& contact = pairs[0].contacts[0];
    const ContactSide& node = node_comes_first ? contact.a : contact.b;
    const ContactSide& face = node_comes_first ? contact.b : contact.a;
    EXPECT_EQ(node.feature, ContactSide::Feature::node);
    EXPECT_EQ(node.nodes[0], 0);
    EXPECT_EQ(node.weights[0], 1);
    EXPECT_EQ(face.feature, ContactSide::Feature::face);
    EXPECT_EQ(face.face, 0);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(face.nodes[i], i);
      EXPECT_NEAR(face.weights[i], 1.0 / 3, 1e-5);
    }
    EXPECT_NEAR(node.position.distance(btVector3(0, btScalar(0.06), 0)), 0, 1e-5);
    EXPECT_NEAR(face.position.distance(btVector3(0, 0, 0)), 0, 1e-5);
    EXPECT_NEAR(contact.normal.y(), node_comes_first ? 1 : -1, 1e-5) << "from b towards a";
    EXPECT_NEAR(contact.depth, 0.04, 1e-5) << "two margins of 0.05";
    EXPECT_TRUE(contact.is_new);
  }
}

/// (body of the node, node, face of the other).
using Key = std::tuple<const btSoftBody*, int, int>;

void expect_consistent(const BodyPairContacts& pair, const BodyContact& contact, btScalar margins) {
  EXPECT_NEAR(contact.normal.length(), 1, 1e-5);
  EXPECT_NEAR(contact.a.position.distance(weighted(*pair.a, contact.a)), 0, 1e-5);
  EXPECT_NEAR(contact.b.position.distance(weighted(*btSoftBody::upcast(pair.b), contact.b)), 0, 1e-5);
  EXPECT_NEAR(contact.depth, margins - contact.normal.dot(contact.a.position - contact.b.position), 1e-5);
}

std::set<Key> keys_of(const BodyPairContacts& pair, btScalar margins) {
  std::set<Key> keys;
  for (const BodyContact& contact : pair.contacts) {
    expect_consistent(pair, contact, margins);
    const bool has_node_on_a = contact.a.feature == ContactSide::Feature::node;
    const Key key = has_node_on_a ? Key(pair.a, contact.a.nodes[0], contact.b.face)
                                  : Key(btSoftBody::upcast(pair.b), contact.b.nodes[0], contact.a.face);
    EXPECT_TRUE(keys.insert(key).second) << "listed twice";
  }
  return keys;
}

/// All nodes of `nodes` within the margins of a face of `faces`.
void add_by_brute_force(const btSoftBody& nodes, const btSoftBody& faces, double margins, std::set<Key>& keys) {
  for (int n = 0; n < nodes.m_nodes.size(); ++n) {
    for (int f = 0; f < faces.m_faces.size(); ++f) {
      const btSoftBody::Face& face = faces.m_faces[f];
      const auto distance =
          static_cast<double>(distance_vertex_triangle(position_of(nodes.m_nodes[n]), position_of(*face.m_n[0]),
                                                       position_of(*face.m_n[1]), position_of(*face.m_n[2])));
      if (distance < margins) keys.emplace(&nodes, n, f);
    }
  }
}

TEST_P(ClassicBodyContacts, of_sheets_at_rest_are_all_that_are_within_the_margins) {
  AnySimulation simulation(GetParam(), reading());
  simulation.world_info().m_gravity.setZero();
  SheetOptions options;
  options.margin = btScalar(0.021);
  btSoftBody& lower = simulation.add(make_sheet(simulation.world_info(), options));
  options.height = btScalar(0.03);
  options.side = btScalar(0.93);
  btSoftBody& upper = simulation.add(make_sheet(simulation.world_info(), options));
  for (btSoftBody* body : {&lower, &upper}) body->m_cfg.piterations = 0;
  simulation.step();
  const Pairs& pairs = simulation.detection().body_contacts();
  ASSERT_EQ(pairs.size(), 1U);
  std::set<Key> expected;
  add_by_brute_force(lower, upper, 0.042, expected);
  add_by_brute_force(upper, lower, 0.042, expected);
  EXPECT_GT(expected.size(), 50U);
  EXPECT_EQ(keys_of(pairs[0], btScalar(0.042)), expected);
}

TEST(BodyContacts, of_a_deformable_step_are_those_of_bullets_array) {
  AnySimulation simulation(World::deformable, reading());
  SheetOptions options;
  btSoftBody& lower = simulation.add(make_sheet(simulation.world_info(), options));
  options.height = btScalar(0.06);
  options.side = btScalar(0.93);
  btSoftBody& upper = simulation.add(make_sheet(simulation.world_info(), options));
  simulation.world().stepSimulation(btScalar(1e-5), 0);
  std::set<Key> expected;
  for (const btSoftBody* body : {&lower, &upper}) {
    const btSoftBody& other = body == &lower ? upper : lower;
    for (int i = 0; i < body->m_faceNodeContacts.size(); ++i) {
      const btSoftBody::DeformableFaceNodeContact& contact = body->m_faceNodeContacts[i];
      expected.emplace(body, static_cast<int>(contact.m_node - &body->m_nodes[0]),
                       static_cast<int>(contact.m_face - &other.m_faces[0]));
    }
  }
  EXPECT_GT(expected.size(), 50U);
  const BodyPairContacts* pair = find(simulation.detection().body_contacts(), lower, upper);
  ASSERT_NE(pair, nullptr);
  EXPECT_EQ(keys_of(*pair, btScalar(0.1)), expected);
}

/// The ground on which a cloth is laid.
enum class Ground { box, sphere, mesh };

std::unique_ptr<btCollisionShape> make_ground(Ground ground, btTriangleMesh& triangles) {
  if (ground == Ground::box) return std::make_unique<btBoxShape>(btVector3(2, btScalar(0.5), 2));
  if (ground == Ground::sphere) return std::make_unique<btSphereShape>(btScalar(0.5));
  const btScalar height = btScalar(0.5);
  triangles.addTriangle(btVector3(-3, height, -3), btVector3(0, height, 6), btVector3(3, height, -3));
  return std::make_unique<btBvhTriangleMeshShape>(&triangles, true);
}

TEST_P(BodyContacts, of_a_cloth_on_a_rigid_object_point_from_the_object_to_its_nodes) {
  for (const Ground ground : {Ground::box, Ground::sphere, Ground::mesh}) {
    btTriangleMesh triangles;
    AnySimulation simulation(GetParam(), reading());
    btRigidBody& object = simulation.add_rigid(make_ground(ground, triangles), btVector3(0, 0, 0));
    SheetOptions options;
    options.height = btScalar(0.53);
    btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
    std::vector<btVector3> places;
    for (int i = 0; i < sheet.m_nodes.size(); ++i) places.push_back(sheet.m_nodes[i].m_x);
    simulation.world().stepSimulation(btScalar(1e-4), 0);
    const Pairs& pairs = simulation.detection().body_contacts();
    ASSERT_EQ(pairs.size(), 1U);
    EXPECT_EQ(pairs[0].a, &sheet);
    EXPECT_EQ(pairs[0].b, &object);
    EXPECT_EQ(pairs[0].state, State::begun);
    EXPECT_EQ(static_cast<int>(pairs[0].contacts.size()), AnySimulation::count_contacts(sheet));
    const bool all_touch = pairs[0].contacts.size() == static_cast<std::size_t>(sheet.m_nodes.size());
    EXPECT_EQ(all_touch, ground != Ground::sphere);
    for (const BodyContact& contact : pairs[0].contacts) {
      EXPECT_EQ(contact.a.feature, ContactSide::Feature::node);
      EXPECT_EQ(contact.b.feature, ContactSide::Feature::object);
      EXPECT_NEAR(contact.a.position.distance(places[static_cast<std::size_t>(contact.a.nodes[0])]), 0, 1e-5);
      if (ground == Ground::sphere) {
        EXPECT_GT(contact.normal.dot(contact.a.position.normalized()), btScalar(0.95));
        EXPECT_NEAR(contact.b.position.length(), 0.5, 0.02) << "Bullet's field of distances is a grid's";
      } else {
        EXPECT_NEAR(contact.normal.y(), 1, 1e-3);
        const btScalar mesh_margin = ground == Ground::mesh ? object.getCollisionShape()->getMargin() : btScalar(0);
        EXPECT_NEAR(contact.b.position.y(), btScalar(0.5) + mesh_margin, 2e-3);
        EXPECT_NEAR(contact.depth, btScalar(0.02) + mesh_margin, 2e-3);
      }
    }
  }
}

/// Counts the events of each list.
struct Tally {
  int begun = 0, persisting = 0, ended = 0, new_contacts = 0, ended_contacts = 0;

  void add(const Pairs& pairs) {
    for (const BodyPairContacts& pair : pairs) {
      begun += pair.state == State::begun;
      persisting += pair.state == State::persists;
      ended += pair.state == State::ended;
      EXPECT_EQ(pair.contacts.empty(), pair.state == State::ended);
      for (const BodyContact& contact : pair.contacts) new_contacts += contact.is_new;
      ended_contacts += static_cast<int>(pair.ended.size());
    }
  }
};

TEST_P(BodyContacts, of_two_balls_that_meet_and_part_begin_persist_and_end_once) {
  Tally told;
  bullet::Settings settings = reading();
  settings.on_contacts = [&told](const Pairs& pairs) { told.add(pairs); };
  AnySimulation simulation(GetParam(), settings);
  simulation.world().setGravity(btVector3(0, 0, 0));
  simulation.world_info().m_gravity.setZero();
  btSoftBody* balls[2];
  for (int i = 0; i < 2; ++i) {
    const btScalar side = i == 0 ? -1 : 1;
    auto ball = make_soft_ball(simulation.world_info(), btVector3(side * btScalar(0.57), 0, 0), btScalar(0.5));
    ball->getCollisionShape()->setMargin(btScalar(0.03));
    balls[i] = &simulation.add(std::move(ball));
  }
  Tally read;
  bool parts = false;
  for (int step = 0; step < 60; ++step) {
    simulation.step([&](btScalar) {
      // They turn back before contacts push them apart, because only the touching pairs count here.
      const btScalar gap = balls[1]->m_nodes[0].m_x.x() - balls[0]->m_nodes[0].m_x.x();
      parts = parts || gap < btScalar(1.02);
      for (int i = 0; i < 2; ++i) {
        balls[i]->setVelocity(btVector3(btScalar((i == 0) == parts ? -0.3 : 0.3), 0, 0));
      }
    });
    read.add(simulation.detection().body_contacts());
  }
  for (const Tally& tally : {told, read}) {
    EXPECT_EQ(tally.begun, 1);
    EXPECT_EQ(tally.ended, 1);
    EXPECT_GT(tally.persisting, 2);
    EXPECT_GT(tally.new_contacts, 2);
    EXPECT_EQ(tally.new_contacts, tally.ended_contacts) << "every contact that came went";
  }
}

/// A cloth that touches a held one from the first step on.
struct Laid {
  AnySimulation simulation;
  btSoftBody* held;
  btSoftBody* cloth;

  explicit Laid(World world, const bullet::Settings& settings = reading()) : simulation(world, settings) {
    SheetOptions options;
    options.nodes_per_side = 5;
    options.fixed = true;
    held = &simulation.add(make_sheet(simulation.world_info(), options));
    options.fixed = false;
    options.height = btScalar(0.0995);
    cloth = &simulation.add(make_sheet(simulation.world_info(), options));
  }
  const Pairs& contacts() { return simulation.detection().body_contacts(); }
};

TEST_P(BodyContacts, are_none_and_cost_no_call_unless_asked_for) {
  bool is_called = false;
  bullet::Settings settings = reading(ReadOut::off);
  settings.on_contacts = [&](const Pairs&) { is_called = true; };
  Laid laid(GetParam(), settings);
  laid.simulation.step();
  EXPECT_TRUE(laid.contacts().empty());
  EXPECT_FALSE(is_called);
  settings.read_out = ReadOut::contacts;
  laid.simulation.detection().set_settings(settings);
  laid.simulation.step();
  EXPECT_FALSE(laid.contacts().empty());
  EXPECT_TRUE(is_called);
  settings.read_out = ReadOut::off;
  laid.simulation.detection().set_settings(settings);
  laid.simulation.step();
  EXPECT_TRUE(laid.contacts().empty());
}

TEST_P(BodyContacts, compare_with_the_last_time_that_they_were_read) {
  Laid laid(GetParam());
  for (int step = 0; step < 3; ++step) laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  EXPECT_EQ(laid.contacts()[0].state, State::begun) << "in a step that nobody has read, and so for the first reader";
  EXPECT_EQ(laid.contacts()[0].state, State::begun) << "however often one step is read";
  for (int step = 0; step < 3; ++step) laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  EXPECT_EQ(laid.contacts()[0].state, State::persists);
}

TEST_P(BodyContacts, are_told_for_each_of_several_steps_in_a_call) {
  int begun = 0, calls = 0;
  bullet::Settings settings = reading();
  settings.on_contacts = [&](const Pairs& pairs) {
    ++calls;
    for (const BodyPairContacts& pair : pairs) begun += pair.state == State::begun;
  };
  Laid laid(GetParam(), settings);
  laid.simulation.world().setInternalTickCallback(
      [](btDynamicsWorld* world, btScalar) {
        static_cast<btSoftBody*>(world->getWorldUserInfo())->setVelocity(btVector3(0, -1, 0));
      },
      laid.cloth, /*isPreTick=*/true);
  const btScalar part = kStep / 4;
  laid.simulation.world().stepSimulation(3 * part + part / 2, 3, part);
  laid.simulation.finish_step();
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(begun, 1);
  ASSERT_EQ(laid.contacts().size(), 1U);
  EXPECT_EQ(laid.contacts()[0].state, State::begun) << "since nobody has read before";
}

TEST_P(BodyContacts, name_no_body_that_is_gone) {
  Laid laid(GetParam());
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  const std::size_t count = laid.contacts()[0].contacts.size();
  laid.simulation.remove(*laid.cloth).reset();
  ASSERT_EQ(laid.contacts().size(), 1U) << "the last step's are still told";
  EXPECT_EQ(laid.contacts()[0].a, laid.held);
  EXPECT_EQ(laid.contacts()[0].b, nullptr);
  EXPECT_EQ(laid.contacts()[0].contacts.size(), count);
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  EXPECT_EQ(laid.contacts()[0].state, State::ended);
  EXPECT_EQ(laid.contacts()[0].b, nullptr);
  EXPECT_EQ(laid.contacts()[0].ended.size(), count);
  laid.simulation.step();
  EXPECT_TRUE(laid.contacts().empty());
}

TEST_P(BodyContacts, tell_a_body_from_one_that_comes_to_its_address) {
  Laid laid(GetParam());
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  // The same object represents a new one made at its address.
  std::unique_ptr<btSoftBody> body = laid.simulation.remove(*laid.cloth);
  laid.simulation.add(std::move(body));
  laid.simulation.step();
  const Pairs& pairs = laid.contacts();
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].state, State::begun);
  EXPECT_EQ(pairs[0].b, laid.cloth);
  EXPECT_EQ(pairs[1].state, State::ended);
  EXPECT_EQ(pairs[1].b, nullptr);
}

TEST_P(BodyContacts, of_a_body_that_sleeps_persist) {
  Laid laid(GetParam());
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  for (btSoftBody* body : {laid.cloth, laid.held}) body->forceActivationState(DISABLE_SIMULATION);
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  EXPECT_EQ(laid.contacts()[0].state, State::persists);
  EXPECT_FALSE(laid.contacts()[0].contacts.empty());
  laid.simulation.remove(*laid.held).reset();
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  EXPECT_EQ(laid.contacts()[0].state, State::ended);
}

TEST_P(BodyContacts, within_a_body_have_it_on_both_sides) {
  AnySimulation simulation(GetParam(), reading());
  SheetOptions options;
  options.margin = btScalar(0.02);
  auto sheet = make_sheet(simulation.world_info(), options);
  // Folded, with a gap of 0.03.
  for (int n = 0; n < sheet->m_nodes.size(); ++n) {
    btVector3& x = sheet->m_nodes[n].m_x;
    if (x.x() > btScalar(1e-3)) x.setValue(-x.x() + btScalar(0.01), btScalar(0.03), x.z());
    sheet->m_nodes[n].m_q = x;
  }
  sheet->setSelfCollision(true);
  btSoftBody& body = simulation.add(std::move(sheet));
  simulation.world().stepSimulation(btScalar(1e-4), 0);
  const BodyPairContacts* pair = find(simulation.detection().body_contacts(), body, body);
  ASSERT_NE(pair, nullptr);
  for (const BodyContact& contact : pair->contacts) {
    EXPECT_EQ(contact.a.feature, ContactSide::Feature::node);
    EXPECT_EQ(contact.b.feature, ContactSide::Feature::face);
  }
}

TEST_P(BodyContacts, of_edges_have_both_edges_and_stand_there_once) {
  bullet::Settings settings = reading(ReadOut::impulses);
  settings.edge_contacts = bullet::EdgeContacts::respond;
  Laid laid(GetParam(), settings);
  laid.cloth->rotate(btQuaternion(btVector3(0, 1, 0), btScalar(0.4)));
  for (btSoftBody* body : {laid.held, laid.cloth}) body->m_cfg.piterations = 0;
  laid.simulation.world().stepSimulation(btScalar(1e-4), 0);
  std::set<std::tuple<int, int, int, int>> expected, found;
  for (const bullet::EdgeContact& edges : laid.simulation.detection().edge_contacts()) {
    ASSERT_EQ(edges.a.body, laid.held);
    expected.emplace(edges.a.nodes[0], edges.a.nodes[1], edges.b.nodes[0], edges.b.nodes[1]);
  }
  EXPECT_GT(expected.size(), 5U);
  ASSERT_EQ(laid.contacts().size(), 1U);
  const BodyPairContacts& pair = laid.contacts()[0];
  for (const BodyContact& contact : pair.contacts) {
    if (contact.a.feature != ContactSide::Feature::edge) continue;
    EXPECT_EQ(contact.b.feature, ContactSide::Feature::edge);
    expect_consistent(pair, contact, btScalar(0.1));
    EXPECT_TRUE(found.emplace(contact.a.nodes[0], contact.a.nodes[1], contact.b.nodes[0], contact.b.nodes[1]).second);
  }
  EXPECT_EQ(found, expected);
}

TEST_P(ClassicBodyContacts, along_the_way_have_a_time_of_impact) {
  Laid laid(GetParam(), reading(ReadOut::contacts, Detection::ccd));
  laid.cloth->translate(btVector3(0, btScalar(0.2), 0));
  laid.cloth->setVelocity(btVector3(0, -30, 0));
  laid.simulation.step();
  ASSERT_EQ(laid.contacts().size(), 1U);
  for (const BodyContact& contact : laid.contacts()[0].contacts) {
    EXPECT_NEAR(contact.time_of_impact, 0.2995 / 0.5, 0.01) << "half a metre in the step";
  }
}

TEST_P(BodyContacts, with_a_mesh_on_the_way_have_a_time_of_impact) {
  btTriangleMesh triangles;
  AnySimulation simulation(GetParam(), reading());
  simulation.world().setGravity(btVector3(0, 0, 0));
  simulation.world_info().m_gravity.setZero();
  btRigidBody& mesh = simulation.add_rigid(make_ground(Ground::mesh, triangles), btVector3(0, btScalar(-0.5), 0));
  mesh.getCollisionShape()->setMargin(0);
  SheetOptions options;
  options.height = btScalar(0.3);
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), options));
  sheet.setVelocity(btVector3(0, -30, 0));
  simulation.world().stepSimulation(kStep, 0);
  const BodyPairContacts* pair = find(simulation.detection().body_contacts(), sheet, mesh);
  ASSERT_NE(pair, nullptr);
  EXPECT_EQ(pair->contacts.size(), static_cast<std::size_t>(sheet.m_nodes.size()));
  for (const BodyContact& contact : pair->contacts) EXPECT_NEAR(contact.time_of_impact, 0.6, 0.01);
}

}  // namespace
}  // namespace softcd::test
