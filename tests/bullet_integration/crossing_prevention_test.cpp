// What the answers to crossings do to free bodies: no momentum comes or goes, and no kinetic energy is added. What they
// leave alone: bodies that are through each other already.

#include "crossing_prevention.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random.hpp"
#include "soft_body_steps.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using bullet::CrossingPrevention;
using bullet::ImpactZones;
using bullet::kClassicWorld;
using bullet::kDeformableWorld;
using bullet::WorldKind;

btVector3 random_vector(Random& random, double size) {
  const auto coordinate = [&] { return btScalar(random.uniform(-size, size)); };
  const btScalar x = coordinate();
  const btScalar y = coordinate();
  return {x, y, coordinate()};
}

struct Motion {
  btVector3 momentum{0, 0, 0};
  btScalar energy = 0;

  void add(const btVector3& velocity, btScalar mass) {
    momentum += velocity * mass;
    energy += mass * velocity.length2() / 2;
  }
};

/// Neither field of velocities has another momentum now than before, nor more energy.
void expect_no_push(const Motion& before, const Motion& after) {
  const btScalar size = btSqrt(btMax(before.energy, btScalar(1)));
  EXPECT_LT((after.momentum - before.momentum).length(), btScalar(1e-4) * size);
  EXPECT_LE(after.energy, before.energy * btScalar(1 + 1e-5) + btScalar(1e-9));
}

/// Two free sheets with different nodes, close above each other that move through each other in the next step, the
/// upper one much faster than the lower one, each node somewhat otherwise than the next.
struct MeetingSheets {
  btSoftBodyWorldInfo world_info;
  std::unique_ptr<btSoftBody> bodies[2];

  explicit MeetingSheets(Random& random) {
    for (int b = 0; b < 2; ++b) {
      SheetOptions options;
      options.nodes_per_side = 6 + b;
      options.height = btScalar(0.05) * btScalar(b);
      bodies[b] = make_sheet(world_info, options);
      bodies[b]->setTotalMass(btScalar(1 + 2 * b));
      bodies[b]->m_cfg.collisions |= btSoftBody::fCollision::VF_DD;
      for (int n = 0; n < bodies[b]->m_nodes.size(); ++n) {
        btSoftBody::Node& node = bodies[b]->m_nodes[n];
        node.m_v = btVector3(0, btScalar(b == 0 ? 9 : -3), 0) + random_vector(random, 2);
      }
    }
  }

  template <class Velocity>
  Motion motion(Velocity velocity) const {
    Motion result;
    for (const auto& body : bodies) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        result.add(velocity(body->m_nodes[n]), 1 / body->m_nodes[n].m_im);
      }
    }
    return result;
  }
  Motion own_motion() const {
    return motion([](const btSoftBody::Node& node) { return node.m_v; });
  }
  Motion mean_motion() const {
    return motion([](const btSoftBody::Node& node) { return (node.m_x - node.m_q) / kStep; });
  }

  void prevent_crossings(const WorldKind& kind) const {
    bullet::Settings settings = test_settings(Detection::ccd);
    settings.edge_contacts = bullet::EdgeContacts::respond;
    bullet::WorldMirror mirror(kind, settings);
    CrossingPrevention prevention(kind, mirror, settings);
    btSoftBody* const pointers[] = {bodies[0].get(), bodies[1].get()};
    EXPECT_TRUE(prevention.run(
        {pointers, 2}, [](btSoftBody&, btSoftBody&) { return true; }, kStep));
  }
};

constexpr int kTries = 5;

// As after contacts of later bodies: Bullet moves nodes that have got their velocities already.
TEST(AnswersToCrossings, keep_what_a_classic_body_has_that_was_moved_but_not_pushed) {
  for (int seed = 0; seed < kTries; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const MeetingSheets sheets(random);
    for (const auto& body : sheets.bodies) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        btSoftBody::Node& node = body->m_nodes[n];
        node.m_q = node.m_x;
        node.m_x += node.m_v * kStep;
        node.m_v = seed == 0 ? btVector3(0, 0, 0) : random_vector(random, 1);
      }
    }
    const Motion own = sheets.own_motion();
    const Motion mean = sheets.mean_motion();
    sheets.prevent_crossings(kClassicWorld);
    expect_no_push(own, sheets.own_motion());
    expect_no_push(mean, sheets.mean_motion());
    EXPECT_LT(sheets.mean_motion().energy, mean.energy / 2) << "they have met";
  }
}

TEST(AnswersToCrossings, keep_what_deformable_bodies_have) {
  for (int seed = 0; seed < kTries; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const MeetingSheets sheets(random);
    const Motion own = sheets.own_motion();
    sheets.prevent_crossings(kDeformableWorld);
    expect_no_push(own, sheets.own_motion());
    EXPECT_LT(sheets.own_motion().energy, own.energy / 2) << "they have met";
  }
}

// Split velocities move nodes out of rigid bodies in this step and are gone after it.
TEST(AnswersToCrossings, make_no_velocity_out_of_split_velocities) {
  Random random(1);
  const MeetingSheets sheets(random);
  const auto split = [](const btSoftBody::Node& node) { return node.m_splitv; };
  bullet::Impact impact{};
  for (int i = 0; i < 4; ++i) {
    impact.nodes[i] = &sheets.bodies[i / 2]->m_nodes[i];
    impact.nodes[i]->m_splitv = random_vector(random, 20);
  }
  const Motion own = sheets.own_motion();
  const Motion splits = sheets.motion(split);
  ImpactZones zones;
  EXPECT_TRUE(zones.join({impact}));
  zones.move_as_one();
  expect_no_push(own, sheets.own_motion());
  expect_no_push(splits, sheets.motion(split));
  for (const btSoftBody::Node* node : impact.nodes) {
    EXPECT_EQ(node->m_v, impact.nodes[0]->m_v);
    EXPECT_EQ(node->m_splitv, impact.nodes[0]->m_splitv);
  }
}

/// Moves a sheet whose middle node alone is below another sheet up until it is free. Returns whether that was answered.
bool is_held_back(const WorldKind& kind, bullet::EdgeContacts edge_contacts) {
  btSoftBodyWorldInfo world_info;
  SheetOptions options;
  options.side = 4;
  options.nodes_per_side = 2;
  const auto ground = make_sheet(world_info, options);
  options.side = 1;
  options.nodes_per_side = 3;
  options.height = btScalar(0.05);
  const auto sheet = make_sheet(world_info, options);
  sheet->translate(btVector3(btScalar(0.3), 0, btScalar(0.1)));
  sheet->m_nodes[4].m_x -= btVector3(0, btScalar(0.1), 0);
  btSoftBody* const bodies[] = {ground.get(), sheet.get()};
  for (btSoftBody* body : bodies) {
    body->m_cfg.collisions |= btSoftBody::fCollision::VF_DD;
    const btVector3 motion(0, body == sheet.get() ? btScalar(0.2) : btScalar(0), 0);
    for (int n = 0; n < body->m_nodes.size(); ++n) {
      btSoftBody::Node& node = body->m_nodes[n];
      node.m_v = motion / kStep;
      node.m_q = node.m_x;
      node.*kind.end += motion;
    }
  }
  bullet::Settings settings = test_settings(Detection::ccd);
  settings.edge_contacts = edge_contacts;
  bullet::WorldMirror mirror(kind, settings);
  return CrossingPrevention(kind, mirror, settings)
      .run(
          {bodies, 2}, [](btSoftBody&, btSoftBody&) { return true; }, kStep);
}

TEST(AnswersToCrossings, let_go_what_is_through_something_where_edges_are_answered) {
  for (const WorldKind* kind : {&kClassicWorld, &kDeformableWorld}) {
    EXPECT_FALSE(is_held_back(*kind, bullet::EdgeContacts::respond));
    EXPECT_TRUE(is_held_back(*kind, bullet::EdgeContacts::off)) << "nodes never pass through faces";
  }
}

}  // namespace
}  // namespace softcd::test
