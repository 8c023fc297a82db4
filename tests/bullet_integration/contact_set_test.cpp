// softcd's VF_SS contacts, compared with Bullet's and with brute force over all pairs, on the same states.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "exact_contacts.hpp"
#include "random.hpp"
#include "scenes/surface_mesh.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using demo::PlugIn;
using demo::Simulation;

/// Node and face, each as (body, index).
using PairKey = std::pair<std::pair<std::size_t, long>, std::pair<std::size_t, long>>;
using ContactMap = std::map<PairKey, btSoftBody::SContact>;

/// Two copies of one state, one in Bullet's world and one in softcd's. The position solver is off, so that bodies
/// stay where Bullet's prediction put them, and contacts can be judged after the step.
struct Twin {
  Simulation simulation;
  std::vector<btSoftBody*> bodies;

  explicit Twin(PlugIn plug_in) : simulation(plug_in, test_settings()) {}

  btSoftBody& add(std::unique_ptr<btSoftBody> body) {
    body->m_cfg.piterations = 0;
    bodies.push_back(&simulation.add(std::move(body)));
    return *bodies.back();
  }

  ContactMap contacts() const {
    ContactMap found;
    for (std::size_t owner = 0; owner < bodies.size(); ++owner) {
      for (int i = 0; i < bodies[owner]->m_scontacts.size(); ++i) {
        const btSoftBody::SContact& contact = bodies[owner]->m_scontacts[i];
        const PairKey key{{owner, contact.m_node - &bodies[owner]->m_nodes[0]}, face_key(contact.m_face)};
        EXPECT_TRUE(found.emplace(key, contact).second) << "a contact was written twice";
      }
    }
    return found;
  }

 private:
  std::pair<std::size_t, long> face_key(const btSoftBody::Face* face) const {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const btSoftBody::tFaceArray& faces = bodies[b]->m_faces;
      if (face >= &faces[0] && face < &faces[0] + faces.size()) return {b, face - &faces[0]};
    }
    ADD_FAILURE() << "a contact names a face of no body";
    return {};
  }
};

/// Bullet's rule: both margins, and twice the node's motion.
long double margin_of(const btSoftBody& a, const btSoftBody& b, const btSoftBody::Node& node) {
  return static_cast<long double>(a.getCollisionShape()->getMargin()) +
         static_cast<long double>(b.getCollisionShape()->getMargin()) +
         2 * static_cast<long double>((node.m_x - node.m_q).length());
}

/// A leaf of Bullet's trees around these nodes, `beyond` larger.
btDbvtVolume leaf_of(const btSoftBody& body, const std::vector<const btSoftBody::Node*>& nodes, btScalar beyond) {
  std::vector<btVector3> places;
  btVector3 velocity(0, 0, 0);
  for (const btSoftBody::Node* node : nodes) {
    places.push_back(node->m_x);
    velocity += node->m_v / btScalar(nodes.size());
  }
  btDbvtVolume box = btDbvtVolume::FromPoints(places.data(), static_cast<int>(places.size()));
  const btScalar growth = body.getCollisionShape()->getMargin() * btScalar(1.25) + beyond;
  box.Expand(btVector3(growth, growth, growth));
  box.SignedExpand(velocity * body.m_sst.sdt * 3);
  return box;
}

/// Checks `found` against all pairs of nodes and faces of different bodies. Pairs within float's rounding of the
/// margin, or of boxes, may go either way.
void expect_exact_set(const Twin& twin, const ContactMap& found) {
  constexpr long double kRounding = 2e-6L;
  std::size_t expected_count = 0;
  for (std::size_t a = 0; a < twin.bodies.size(); ++a) {
    for (std::size_t b = 0; b < twin.bodies.size(); ++b) {
      if (a == b) continue;
      const btSoftBody& nodes = *twin.bodies[a];
      const btSoftBody& faces = *twin.bodies[b];
      for (int n = 0; n < nodes.m_nodes.size(); ++n) {
        const long double margin = margin_of(nodes, faces, nodes.m_nodes[n]);
        for (int f = 0; f < faces.m_faces.size(); ++f) {
          const btSoftBody::Face& face = faces.m_faces[f];
          const auto are_in_boxes = [&](long double beyond) {
            return Intersect(leaf_of(nodes, {&nodes.m_nodes[n]}, btScalar(beyond)),
                             leaf_of(faces, {face.m_n[0], face.m_n[1], face.m_n[2]}, btScalar(beyond)));
          };
          const long double distance = distance_of(nodes.m_nodes[n], face);
          const bool is_found = found.count({{a, n}, {b, f}}) != 0;
          if (distance < margin - kRounding && are_in_boxes(-kRounding)) {
            ++expected_count;
            EXPECT_TRUE(is_found) << "missed: node " << n << " of body " << a << ", face " << f;
          } else if (distance > margin + kRounding || !are_in_boxes(kRounding)) {
            EXPECT_FALSE(is_found) << "no contact: node " << n << " of body " << a << ", face " << f;
          }
        }
      }
    }
  }
  EXPECT_GT(expected_count, 0U) << "the scene has no contacts to judge";
}

/// Fields that Bullet computes from positions differ by float's rounding. The closest point is off by some
/// roundings of the coordinates' extent; that turns the normal by as much over the distance.
void expect_same_fields(const btSoftBody::SContact& ours, const btSoftBody::SContact& natives, double distance) {
  constexpr double kPointError = 64 * 0x1p-24;  // coordinates are below 1
  EXPECT_NEAR((ours.m_normal - natives.m_normal).length(), 0, 1e-6 + kPointError / distance);
  const double weight_error = kPointError / 0.05;  // the faces' smallest height
  EXPECT_NEAR((ours.m_weights - natives.m_weights).length(), 0, weight_error);
  EXPECT_FLOAT_EQ(float(ours.m_margin), float(natives.m_margin));
  EXPECT_EQ(ours.m_friction, natives.m_friction);
  EXPECT_NEAR(ours.m_cfm[0], natives.m_cfm[0], weight_error);
  EXPECT_NEAR(ours.m_cfm[1], natives.m_cfm[1], weight_error);
}

struct Comparison {
  std::size_t native_count = 0;
  std::size_t our_count = 0;
};

/// Runs one step of the same scene with Bullet and with softcd and compares.
template <class Build>
Comparison compare(PlugIn plug_in, Build build) {
  Twin natives(PlugIn::none);
  Twin ours(plug_in);
  for (Twin* twin : {&natives, &ours}) {
    build(*twin);
    twin->simulation.step(kStep);
  }
  const ContactMap native_contacts = natives.contacts();
  const ContactMap our_contacts = ours.contacts();
  expect_exact_set(ours, our_contacts);
  for (const auto& [key, native_contact] : native_contacts) {
    const auto same = our_contacts.find(key);
    if (same == our_contacts.end()) {
      ADD_FAILURE() << "Bullet alone finds node " << key.first.second << ", face " << key.second.second;
      continue;
    }
    const auto& [node, face] = key;
    const auto distance =
        static_cast<double>(distance_of(ours.bodies[node.first]->m_nodes[static_cast<int>(node.second)],
                                        ours.bodies[face.first]->m_faces[static_cast<int>(face.second)]));
    expect_same_fields(same->second, native_contact, distance);
  }
  std::printf("contacts: softcd %zu, Bullet %zu\n", our_contacts.size(), native_contacts.size());
  return {native_contacts.size(), our_contacts.size()};
}

/// Moves every node a little and gives it a velocity, the same in every copy.
void shake(btSoftBody& body, std::uint64_t seed, double offset, double speed) {
  Random random(seed);
  const auto to_bullet = [](Vec3d v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); };
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    body.m_nodes[i].m_x += to_bullet(random.in_box(offset));
    body.m_nodes[i].m_v = to_bullet(random.in_box(speed));
  }
}

void build_patches(Twin& twin) {
  SheetOptions options;
  options.margin = btScalar(0.03);
  btSoftBody& lower = twin.add(make_sheet(twin.simulation.world_info(), options));
  lower.m_cfg.kDF = btScalar(0.7);
  lower.m_cfg.kSHR = btScalar(0.8);
  options.height = btScalar(0.04);
  options.margin = btScalar(0.02);
  btSoftBody& upper = twin.add(make_sheet(twin.simulation.world_info(), options));
  upper.rotate(btQuaternion(btVector3(0, 1, 0), btScalar(0.4)));
  shake(lower, 1, 0.03, 2);
  shake(upper, 2, 0.03, 2);
  for (int i = 0; i < 20; ++i) lower.setMass(i, 0);
}

void build_ball_on_cloth(Twin& twin) {
  SheetOptions options;
  options.margin = btScalar(0.02);
  btSoftBody& cloth = twin.add(make_sheet(twin.simulation.world_info(), options));
  shake(cloth, 3, 0.02, 1);
  auto ball = demo::make_ball(twin.simulation.world_info(), btVector3(0, btScalar(0.3), 0), btScalar(0.3), 2);
  ball->getCollisionShape()->setMargin(btScalar(0.02));
  ball->setTotalMass(1);
  twin.add(std::move(ball));
}

class ContactSet : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, ContactSet, testing::ValuesIn(kPlugIns), plug_in_name);

TEST_P(ContactSet, of_two_patches_is_exact_and_holds_bullets) {
  const Comparison comparison = compare(GetParam(), build_patches);
  EXPECT_GT(comparison.native_count, 1000U);
}

TEST_P(ContactSet, of_a_ball_on_a_cloth_is_exact_and_holds_bullets) {
  const Comparison comparison = compare(GetParam(), build_ball_on_cloth);
  EXPECT_GT(comparison.native_count, 50U);
}

// Bullet's prediction moves the nodes of such a ball to its shape, upwards, although their velocities are downwards.
TEST(ContactSet, of_a_fast_ball_that_regains_its_shape_is_exact) {
  Twin twin(PlugIn::one_line_world);
  build_ball_on_cloth(twin);
  btSoftBody& ball = *twin.bodies[1];
  for (int i = 0; i < ball.m_nodes.size(); ++i) ball.setMass(i, btScalar(0.01));
  ball.setPose(/*bvolume=*/false, /*bframe=*/true);
  ball.m_cfg.kMT = btScalar(0.6);
  for (int i = 0; i < ball.m_nodes.size(); ++i) {
    btVector3& x = ball.m_nodes[i].m_x;
    x.setY(btScalar(0.75) + 2 * (x.y() - btScalar(0.3)));
    ball.m_nodes[i].m_v = btVector3(8, -8, 0);
  }
  twin.simulation.step(kStep);
  expect_exact_set(twin, twin.contacts());
}

// Bullet's float test gives up on triangles whose legs are shorter than some 1.86 cm.
TEST(ContactSet, of_fine_triangles_is_exact_where_bullet_finds_none) {
  const Comparison comparison = compare(PlugIn::one_line_world, [](Twin& twin) {
    SheetOptions options;
    options.side = btScalar(0.1);
    options.margin = btScalar(0.002);
    twin.add(make_sheet(twin.simulation.world_info(), options));
    options.height = btScalar(0.003);
    twin.add(make_sheet(twin.simulation.world_info(), options));
  });
  EXPECT_GT(comparison.our_count, 100U);
}

TEST(ContactSet, is_the_same_whichever_way_is_plugged_in) {
  std::vector<std::vector<std::pair<PairKey, btScalar>>> results;
  for (const PlugIn plug_in : kPlugIns) {
    Twin twin(plug_in);
    build_patches(twin);
    twin.simulation.step(kStep);
    auto& result = results.emplace_back();
    for (const auto& [key, contact] : twin.contacts()) result.emplace_back(key, contact.m_cfm[0]);
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(ContactSet, is_written_in_ascending_order) {
  Twin twin(PlugIn::one_line_world);
  build_patches(twin);
  twin.simulation.step(kStep);
  for (const btSoftBody* body : twin.bodies) {
    for (int i = 1; i < body->m_scontacts.size(); ++i) {
      const btSoftBody::SContact& before = body->m_scontacts[i - 1];
      const btSoftBody::SContact& after = body->m_scontacts[i];
      EXPECT_TRUE(before.m_node < after.m_node || (before.m_node == after.m_node && before.m_face < after.m_face));
    }
  }
}

// Within a body Bullet has no rule. softcd's is the sum of margins, for any motion.
TEST(ContactSet, within_a_body_is_the_non_incident_pairs_within_twice_the_margin) {
  Twin twin(PlugIn::one_line_world);
  SheetOptions options;
  options.margin = btScalar(0.03);
  btSoftBody& sheet = twin.add(make_sheet(twin.simulation.world_info(), options));
  sheet.setSelfCollision(true);
  for (int i = 0; i < sheet.m_nodes.size(); ++i) {  // rolled up: both halves lie on each other
    btVector3& x = sheet.m_nodes[i].m_x;
    if (x.x() > 0) x = btVector3(-x.x(), btScalar(0.05), x.z());
  }
  shake(sheet, 4, 0.01, 1);
  twin.simulation.step(kStep);
  const ContactMap found = twin.contacts();
  std::size_t expected_count = 0;
  for (int n = 0; n < sheet.m_nodes.size(); ++n) {
    for (int f = 0; f < sheet.m_faces.size(); ++f) {
      const btSoftBody::Face& face = sheet.m_faces[f];
      const btSoftBody::Node* node = &sheet.m_nodes[n];
      const bool is_incident = face.m_n[0] == node || face.m_n[1] == node || face.m_n[2] == node;
      const long double distance = distance_of(*node, face);
      const bool is_found = found.count({{0, n}, {0, f}}) != 0;
      if (is_incident || distance > 0.06L + 1e-6L) {
        EXPECT_FALSE(is_found);
      }
      if (!is_incident && distance < 0.06L - 1e-6L) {
        EXPECT_TRUE(is_found);
        ++expected_count;
      }
    }
  }
  EXPECT_GT(expected_count, 50U);
}

// A small triangle hits a large one of its body and is through it when contacts are detected.
TEST_P(ContactSet, within_a_body_pushes_nodes_back_to_where_they_came_from) {
  for (const bullet::Contacts contacts : {bullet::Contacts::all, bullet::Contacts::closest_feature}) {
    bullet::Settings settings = cpu_settings();
    settings.contacts = contacts;
    demo::Simulation simulation(GetParam(), settings);
    simulation.set_gravity(btVector3(0, 0, 0));
    constexpr btScalar kHeight = btScalar(0.08);
    demo::SurfaceMesh mesh;
    mesh.positions = {{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}};
    for (const btVector3& corner :
         {btVector3(0, 0, 0), btVector3(btScalar(0.1), 0, 0), btVector3(0, 0, btScalar(0.1))}) {
      mesh.positions.push_back(corner + btVector3(0, kHeight, 0));
    }
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    auto made = demo::make_body(simulation.world_info(), mesh, 1);
    made->getCollisionShape()->setMargin(btScalar(0.02));
    made->setSelfCollision(true);
    made->m_cfg.collisions |= btSoftBody::fCollision::VF_SS;
    btSoftBody& body = simulation.add(std::move(made));
    for (int i = 3; i < 6; ++i) body.m_nodes[i].m_v.setY(-(kHeight + btScalar(0.02)) / kStep);
    simulation.step(kStep);
    const btVector3 area =
        btCross(body.m_nodes[2].m_x - body.m_nodes[0].m_x, body.m_nodes[1].m_x - body.m_nodes[0].m_x);
    for (int i = 3; i < 6; ++i) EXPECT_GT(area.dot(body.m_nodes[i].m_x - body.m_nodes[0].m_x), 0) << "node " << i;
  }
}

}  // namespace
}  // namespace softcd::test
