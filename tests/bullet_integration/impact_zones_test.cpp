// Impact zones: nodes that move as one rigid body, and the constraints of their motion.

#include "crossings/impact_zones.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <vector>

#include "random.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using bullet::ConstrainedNodes;
using bullet::Impact;
using bullet::ImpactZones;
using Node = btSoftBody::Node;

btVector3 random_offset(Random& random, double size) {
  const Vec3d v = random.in_box(size);
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

/// Twelve nodes anywhere, of masses from 1 to 3, that chains of impacts connect.
struct Zone {
  static constexpr int kNodes = 12;

  btSoftBodyWorldInfo world_info;
  std::unique_ptr<btSoftBody> body;

  explicit Zone(Random& random, double speed) {
    std::array<btVector3, kNodes> places;
    for (btVector3& x : places) x = random_offset(random, 1);
    body = std::make_unique<btSoftBody>(&world_info, kNodes, places.data(), nullptr);
    for (int n = 0; n < kNodes; ++n) {
      body->setMass(n, btScalar(random.uniform(1, 3)));
      node(n).m_v = random_offset(random, speed);
      node(n).m_splitv.setZero();
    }
  }

  Node& node(int n) const { return body->m_nodes[n]; }

  void move_as_one(const ConstrainedNodes& constrained = {}) const {
    std::vector<Impact> impacts;
    for (int first = 0; first + 3 < kNodes; ++first) {
      Impact impact{};
      for (int i = 0; i < 4; ++i) {
        impact.nodes[i] = &node(first + i);
        impact.constraints[i] = constrained.find(node(first + i));
      }
      impacts.push_back(impact);
    }
    ImpactZones zones(&Node::m_x, kStep);
    EXPECT_TRUE(zones.join(impacts));
    EXPECT_FALSE(zones.join(impacts)) << "all are in it";
    zones.move_as_one();
  }

  btVector3 momentum() const {
    btVector3 sum(0, 0, 0);
    for (int n = 0; n < kNodes; ++n) sum += node(n).m_v / node(n).m_im;
    return sum;
  }
  btVector3 angular_momentum() const {
    btVector3 sum(0, 0, 0);
    for (int n = 0; n < kNodes; ++n) sum += node(n).m_x.cross(node(n).m_v) / node(n).m_im;
    return sum;
  }
  btScalar energy() const {
    btScalar sum = 0;
    for (int n = 0; n < kNodes; ++n) sum += node(n).m_v.length2() / node(n).m_im / 2;
    return sum;
  }
  /// How fast two nodes' distance changes at most.
  btScalar strain_rate() const {
    btScalar most = 0;
    for (int a = 0; a < kNodes; ++a) {
      for (int b = 0; b < a; ++b) {
        most = btMax(most, btFabs((node(a).m_v - node(b).m_v).dot((node(a).m_x - node(b).m_x).normalized())));
      }
    }
    return most;
  }
};

TEST(ImpactZones, keep_momentum_and_angular_momentum_and_take_energy) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Zone zone(random, 1);
    const btVector3 momentum = zone.momentum();
    const btVector3 angular_momentum = zone.angular_momentum();
    const btScalar energy = zone.energy();
    zone.move_as_one();
    EXPECT_LT((zone.momentum() - momentum).length(), 1e-4);
    EXPECT_LT((zone.angular_momentum() - angular_momentum).length(), 1e-4);
    EXPECT_LT(zone.energy(), energy);
    EXPECT_LT(zone.strain_rate(), 1e-5);
  }
}

// A zone that turned faster would be stretched.
TEST(ImpactZones, turn_by_a_quarter_of_a_radian_at_most) {
  Random random(1);
  const Zone zone(random, 1000);
  const btScalar energy = zone.energy();
  zone.move_as_one();
  EXPECT_LT(zone.energy(), energy);
  for (int a = 0; a < Zone::kNodes; ++a) {
    const btVector3 ab = zone.node(a).m_x - zone.node(0).m_x;
    const btVector3 way = (zone.node(a).m_v - zone.node(0).m_v) * kStep;
    EXPECT_LE(way.length(), btScalar(0.2501) * ab.length());
  }
}

// A dancer turns, and a skirt that is pinched between her and its own waist turns with her.
TEST(ImpactZones, are_carried_along_by_nodes_that_the_app_turns) {
  Random random(2);
  const Zone zone(random, 5);
  const btQuaternion turn(btVector3(1, 2, 3).normalized(), btScalar(0.4));
  const btVector3 center(btScalar(0.3), btScalar(-0.2), 1);
  const btVector3 shift(btScalar(0.1), 0, btScalar(0.2));
  const auto goal = [&](const btVector3& x) { return center + quatRotate(turn, x - center) + shift; };
  for (int n = 0; n < 5; ++n) {
    zone.body->setMass(n, 0);
    zone.node(n).m_v = (goal(zone.node(n).m_x) - zone.node(n).m_x) / kStep;
  }
  zone.move_as_one();
  for (int n = 0; n < Zone::kNodes; ++n) {
    EXPECT_LT((zone.node(n).m_x + kStep * zone.node(n).m_v).distance(goal(zone.node(n).m_x)), 1e-4) << n;
  }
}

TEST(ImpactZones, of_nodes_on_a_line_move_as_one) {
  Random random(3);
  const Zone zone(random, 1);
  for (int n = 0; n < Zone::kNodes; ++n) zone.node(n).m_x = btVector3(btScalar(n), 0, 0);
  const btVector3 momentum = zone.momentum();
  const btScalar energy = zone.energy();
  zone.move_as_one();
  EXPECT_LT((zone.momentum() - momentum).length(), 1e-3);
  EXPECT_LT(zone.energy(), energy);
  EXPECT_LT(zone.strain_rate(), 1e-4);
}

/// A node that touches something rigid below it.
void add_rigid_contact(btSoftBody& body, int node, const btVector3& normal = btVector3(0, 1, 0)) {
  body.m_nodes[node].m_constrained = 1;
  btSoftBody::DeformableNodeRigidContact contact;
  contact.m_node = &body.m_nodes[node];
  contact.m_cti.m_normal = normal;
  body.m_nodeRigidContacts.push_back(contact);
}

// Zones in contact with rigid objects slide as one body, whatever else pushes them down. Their sliding motion before
// adds no energy.
TEST(ImpactZones, are_not_pushed_into_what_is_rigid_and_get_no_energy_from_it) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Zone zone(random, 1);
    for (const int n : {1, 5, 9}) {
      add_rigid_contact(*zone.body, n);
      zone.node(n).m_v.setY(0);
    }
    for (const int n : {0, 3, 7}) zone.node(n).m_v.setY(-2);
    ConstrainedNodes constrained;
    constrained.add(*zone.body);
    const btScalar energy = zone.energy();
    zone.move_as_one(constrained);
    EXPECT_LT(zone.energy(), energy);
    EXPECT_LT(zone.strain_rate(), 1e-5);
    for (const int n : {1, 5, 9}) EXPECT_NEAR(zone.node(n).m_v.y(), 0, 0.03) << n;
  }
}

Impact make_impact(const Zone& zone, const btVector3& normal, const ConstrainedNodes& constrained) {
  Impact impact{};
  constexpr btScalar kWeights[] = {1, btScalar(-0.5), btScalar(-0.3), btScalar(-0.2)};
  for (int i = 0; i < 4; ++i) {
    impact.nodes[i] = &zone.node(i);
    impact.weights[i] = kWeights[i];
    impact.constraints[i] = constrained.find(zone.node(i));
  }
  impact.normal = normal;
  impact.friction = btScalar(0.5);
  return impact;
}

// However they are inclined to it, and whether Bullet's solver lets them approach it or not.
TEST(InelasticImpulses, of_nodes_that_touch_what_is_rigid_add_no_energy) {
  int answered = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const Zone zone(random, 10);
    for (const int n : {0, 1}) add_rigid_contact(*zone.body, n);
    ConstrainedNodes constrained;
    constrained.add(*zone.body);
    const double tilt = seed % 2 == 0 ? 1e-4 : 1;
    const btVector3 normal = (btVector3(0, seed % 4 < 2 ? 1 : -1, 0) + random_offset(random, tilt)).normalized();
    const std::array<btScalar, 2> heights = {zone.node(0).m_v.y(), zone.node(1).m_v.y()};
    const btScalar energy = zone.energy();
    bullet::apply_inelastic_impulses({make_impact(zone, normal, constrained)});
    EXPECT_LE(zone.energy(), energy * btScalar(1 + 1e-5));
    answered += zone.energy() < energy ? 1 : 0;
    for (const int n : {0, 1}) {
      EXPECT_NEAR(zone.node(n).m_v.y(), heights[static_cast<std::size_t>(n)], 1e-4) << "its contact's";
    }
  }
  EXPECT_GT(answered, 50);
}

// Nodes in a corner of a rigid object slide past each other. Nearly all of the impulse goes into the rigid object.
TEST(InelasticImpulses, between_nodes_in_a_corner_add_no_energy) {
  Random random(1);
  const Zone zone(random, 0);
  for (int n = 0; n < 4; ++n) {
    zone.body->setMass(n, btScalar(0.01));
    add_rigid_contact(*zone.body, n);
  }
  for (const int n : {0, 2}) add_rigid_contact(*zone.body, n, btVector3(1, 0, 0));
  zone.node(0).m_v = btVector3(0, 0, btScalar(0.6));
  zone.node(1).m_v = btVector3(btScalar(0.6), 0, btScalar(0.3));
  zone.node(2).m_v = btVector3(0, 0, btScalar(0.35));
  zone.node(3).m_v = btVector3(btScalar(0.07), 0, btScalar(0.63));
  ConstrainedNodes constrained;
  constrained.add(*zone.body);
  Impact impact = make_impact(zone, btVector3(btScalar(0.0014), 1, 0).normalized(), constrained);
  constexpr btScalar kWeights[] = {1, 0, btScalar(-0.3), btScalar(-0.7)};
  std::copy(std::begin(kWeights), std::end(kWeights), impact.weights);
  const btScalar energy = zone.energy();
  bullet::apply_inelastic_impulses({impact});
  EXPECT_LT(zone.energy(), energy);
}

}  // namespace
}  // namespace softcd::test
