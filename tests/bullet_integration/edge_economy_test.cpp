// Settings::contacts chooses contacts of edges, too.

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include "any_simulation.hpp"
#include "exact_contacts.hpp"
#include "reference_distance.hpp"
#include "still_sheets.hpp"

namespace softcd::test {
namespace {

/// Two edges in contact, by their nodes.
using Edges = std::set<Feature>;

Feature edge_of(const bullet::EdgeContact::Side& side) {
  return {&side.body->m_nodes[side.nodes[0]], &side.body->m_nodes[side.nodes[1]]};
}

/// The edges in contact that Bullet's solver is given, behind `node_contacts` contacts of each body's nodes.
std::set<Edges> given_edges(const std::vector<btSoftBody*>& bodies, const std::vector<int>& node_contacts) {
  std::set<Edges> given;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const btSoftBody::tSContactArray& contacts = bodies[b]->m_scontacts;
    for (int i = node_contacts[b]; i + 1 < contacts.size(); i += 2) {
      given.insert({{contacts[i].m_node, contacts[i + 1].m_node}, feature_of(contacts[i])});
    }
  }
  return given;
}

/// The distance of an edge from the nearest of the other side's faces at its own edge.
long double distance_from_faces(const bullet::EdgeContact::Side& edge, const bullet::EdgeContact::Side& other) {
  const auto end = [&](int i) { return position_of(edge.body->m_nodes[edge.nodes[i]]); };
  long double nearest = 1e9L;
  for (int f = 0; f < other.body->m_faces.size(); ++f) {
    const btSoftBody::Face& face = other.body->m_faces[f];
    if (!has(face, edge_of(other))) continue;
    for (int i = 0; i < 3; ++i) {
      const auto corner = [&](int c) { return position_of(*face.m_n[c % 3]); };
      nearest = std::min(nearest, distance_edge_edge(end(0), end(1), corner(i), corner(i + 1)));
      if (i < 2) nearest = std::min(nearest, distance_vertex_triangle(end(i), corner(0), corner(1), corner(2)));
    }
  }
  return nearest;
}

bool is_end_nearest(const bullet::EdgeContact::Side& side) {
  return !(side.weights[0] > 0) || !(side.weights[1] > 0);
}

class EdgeEconomy : public testing::TestWithParam<Detection> {
 protected:
  static bullet::Settings settings(bullet::EdgeContacts edges) {
    bullet::Settings settings = test_settings(GetParam());
    settings.contacts = Contacts::closest_feature;
    settings.edge_contacts = edges;
    return settings;
  }
  /// Two sheets that do not intersect.
  static void build_bumps(Still& still, std::uint64_t seed) {
    Random random(seed);
    still.add(bumpy(0, btScalar(0.025), random));
    still.add(bumpy(btScalar(0.06), btScalar(0.025), random));
    still.step();
  }
};
INSTANTIATE_TEST_SUITE_P(Detections, EdgeEconomy, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& parameter) { return parameter.param == Detection::dcd ? "dcd" : "ccd"; });

TEST_P(EdgeEconomy, gives_edges_that_are_nearest_along_the_faces_at_them) {
  std::size_t given_count = 0, dropped_count = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Still without(settings(bullet::EdgeContacts::off));
    build_bumps(without, seed);
    std::vector<int> node_contacts;
    for (const btSoftBody* body : without.bodies()) node_contacts.push_back(body->m_scontacts.size());
    Still still(settings(bullet::EdgeContacts::respond));
    build_bumps(still, seed);
    const std::set<Edges> given = given_edges(still.bodies(), node_contacts);
    for (const bullet::EdgeContact& contact : still.simulation().detection()->edge_contacts()) {
      const long double nearest =
          std::min(distance_from_faces(contact.a, contact.b), distance_from_faces(contact.b, contact.a));
      const long double gain = static_cast<long double>(contact.distance) - nearest;
      if (gain > 0 && gain < kRounding) continue;
      const bool is_nearest = gain <= 0 && !is_end_nearest(contact.a) && !is_end_nearest(contact.b);
      EXPECT_EQ(given.count({edge_of(contact.a), edge_of(contact.b)}), is_nearest ? 1U : 0U) << double(gain);
      ++(is_nearest ? given_count : dropped_count);
    }
  }
  EXPECT_GT(given_count, 20U);
  EXPECT_GT(dropped_count, given_count);
}

/// Two bumpy sheets in the deformable world, after a step that is too short to move them.
struct DeformableBumps {
  explicit DeformableBumps(bullet::EdgeContacts edges) : simulation(World::deformable, settings_with(edges)) {
    simulation.set_gravity(btVector3(0, 0, 0));
    Random random(1);
    for (const btScalar height : {btScalar(0), btScalar(0.06)}) {
      auto sheet = demo::make_cloth(simulation.world_info(), bumpy(height, btScalar(0.025), random), 1);
      sheet->getCollisionShape()->setMargin(kThickness);
      const btSoftBody& body = simulation.add(std::move(sheet));
      bodies.push_back(&body);
    }
    simulation.step(btScalar(1e-5));
  }
  static bullet::Settings settings_with(bullet::EdgeContacts edges) {
    bullet::Settings settings;
    settings.backend = backend_under_test();
    settings.edge_contacts = edges;
    return settings;
  }
  std::size_t given_count() const {
    std::size_t count = 0;
    for (const btSoftBody* body : bodies) count += static_cast<std::size_t>(body->m_faceNodeContacts.size());
    return count;
  }

  AnySimulation simulation;
  std::vector<const btSoftBody*> bodies;
};

// Bullet's solver pushes once for each contact there, with a spring of bounded force. With fewer contacts of edges,
// balls sink through a cloth.
TEST(EdgesInTheDeformableWorld, all_have_contacts_by_default) {
  DeformableBumps bumps(bullet::EdgeContacts::automatic);
  const std::size_t edge_count = bumps.simulation.detection().edge_contacts().size();
  EXPECT_GT(edge_count, 100U);
  const DeformableBumps without(bullet::EdgeContacts::off);
  EXPECT_EQ(bumps.given_count() - without.given_count(), 2 * edge_count);
}

/// A flat sheet that touches itself, at rest in the deformable world, without gravity. Its edges are 0.125 apart.
struct FlatSheet {
  FlatSheet(World world, const std::optional<bullet::Settings>& settings, btScalar margin)
      : simulation(world, settings) {
    simulation.set_gravity(btVector3(0, 0, 0));
    auto sheet = demo::make_cloth(simulation.world_info(), flat(0), 1);
    sheet->getCollisionShape()->setMargin(margin);
    sheet->setSelfCollision(true);
    body = &simulation.add(std::move(sheet));
  }
  /// Returns the kinetic energy after a second.
  double energy() {
    for (int step = 0; step < 240; ++step) simulation.step(btScalar(1) / 240);
    double energy = 0;
    for (int i = 0; i < body->m_nodes.size(); ++i) {
      energy += double(body->m_nodes[i].m_v.length2()) / double(body->m_nodes[i].m_im) / 2;
    }
    return energy;
  }

  AnySimulation simulation;
  btSoftBody* body;
};

// Bullet's trees find no contacts within a flat part of a surface. They would push against its springs all the time.
TEST(ContactsWithinABody, do_not_crumple_a_flat_sheet_that_is_finer_than_the_margins) {
  for (const World world : {World::deformable, World::attached_deformable}) {
    for (const btScalar margin : {btScalar(0.05), btScalar(0.08), btScalar(0.12)}) {
      SCOPED_TRACE(double(margin));
      EXPECT_LT(FlatSheet(world, std::nullopt, margin).energy(), 1e-9) << "with Bullet alone";
      FlatSheet sheet(world, DeformableBumps::settings_with(bullet::EdgeContacts::automatic), margin);
      EXPECT_LT(sheet.energy(), 1e-9);
      EXPECT_GT(sheet.simulation.detection().contact_report().statistics().vt_contacts, 0U) << "which are not given";
    }
  }
}

TEST(ContactsWithinABody, push_the_layers_of_a_roll_apart) {
  const auto contacts_with = [](bullet::EdgeContacts edges) {
    AnySimulation simulation(World::deformable, DeformableBumps::settings_with(edges));
    auto roll = make_roll(simulation.world_info(), 40, 5);
    roll->setSelfCollision(true);
    btSoftBody& body = simulation.add(std::move(roll));
    simulation.step(btScalar(1e-5));
    return body.m_faceNodeContacts.size();
  };
  EXPECT_GT(contacts_with(bullet::EdgeContacts::automatic), contacts_with(bullet::EdgeContacts::off) + 100);
}

}  // namespace
}  // namespace softcd::test
