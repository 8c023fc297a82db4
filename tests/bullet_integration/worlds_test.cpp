// Simulations that run for a while: bodies come to rest where they should.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "scenes/folding_cloth.hpp"
#include "scenes/two_cloths.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using demo::Collision;
using demo::FoldingCloth;
using demo::PlugIn;
using demo::SceneOptions;
using demo::Simulation;
using demo::TwoCloths;

SceneOptions scene_options(Collision collision, PlugIn plug_in, Detection detection, int nodes_per_side) {
  SceneOptions options;
  options.collision = collision;
  options.plug_in = plug_in;
  options.settings = test_settings(detection);
  options.size = nodes_per_side;
  return options;
}

void run(demo::Scene& scene, double seconds) {
  while (double(scene.time()) < seconds) scene.step();
}

constexpr int kClothSize = 20;
constexpr double kSettled = 2;

struct Rest {
  double mean_height = 0;
  std::size_t penetrating = 0;
};

Rest rest_of_upper_cloth(Collision collision, PlugIn plug_in, Detection detection) {
  TwoCloths scene(scene_options(collision, plug_in, detection, kClothSize));
  run(scene, kSettled);
  return {double(mean_height(scene.upper())), scene.count_penetrating_vertices()};
}

const Rest& rest_with_bullet() {
  static const Rest rest = rest_of_upper_cloth(Collision::bullet, PlugIn::none, Detection::dcd);
  return rest;
}

class PluggedIn : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, PluggedIn, testing::ValuesIn(kPlugIns), plug_in_name);

TEST_P(PluggedIn, a_cloth_rests_on_another_as_with_bullet) {
  const Rest rest = rest_of_upper_cloth(Collision::softcd, GetParam(), Detection::dcd);
  EXPECT_EQ(rest.penetrating, 0U);
  EXPECT_EQ(rest_with_bullet().penetrating, 0U);
  EXPECT_NEAR(rest.mean_height, rest_with_bullet().mean_height, 0.05);  // the cloths are 6 wide and fell 0.3
}

TEST_P(PluggedIn, a_cloth_rests_on_another_with_continuous_detection) {
  const Rest rest = rest_of_upper_cloth(Collision::softcd, GetParam(), Detection::ccd);
  EXPECT_EQ(rest.penetrating, 0U);
  EXPECT_NEAR(rest.mean_height, rest_with_bullet().mean_height, 0.1);
}

TEST_P(PluggedIn, a_folded_cloth_rests_on_itself) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    FoldingCloth scene(scene_options(Collision::softcd, GetParam(), detection, 12));
    const btScalar margin = scene.cloth().getCollisionShape()->getMargin();
    run(scene, 1.5);
    EXPECT_EQ(scene.count_penetrating_vertices(), 0U);
    for (int layer = 1; layer < FoldingCloth::kLayers; ++layer) {
      EXPECT_GT(scene.mean_gap_below(layer), margin);
      EXPECT_LT(scene.mean_gap_below(layer), 6 * margin);
    }
  }
}

TEST(Bullet, a_folded_cloth_falls_through_itself) {
  for (const Collision collision : {Collision::bullet, Collision::off}) {
    FoldingCloth scene(scene_options(collision, PlugIn::none, Detection::dcd, 12));
    run(scene, 1.5);
    EXPECT_GT(scene.count_penetrating_vertices(), 100U);
  }
}

TEST(Bullet, a_cloth_falls_through_another_whose_flag_is_off) {
  EXPECT_GT(rest_of_upper_cloth(Collision::off, PlugIn::none, Detection::dcd).penetrating, 100U);
}

struct Shot {
  int through = 0;  ///< nodes below the sheet half a second later
  btScalar highest = 0;
};

/// A cloth that hits a sheet with fixed nodes at 40 m/s: 0.67 m a step, from 0.3 m.
Shot shoot(PlugIn plug_in, Detection detection) {
  Simulation simulation(plug_in, test_settings(detection));
  SheetOptions options;
  options.fixed = true;
  options.side = 2;
  options.nodes_per_side = 17;
  options.margin = btScalar(0.02);
  simulation.add(make_sheet(simulation.world_info(), options));
  options.fixed = false;
  options.side = 1;
  options.nodes_per_side = 12;
  options.height = btScalar(0.3);
  btSoftBody& cloth = simulation.add(make_sheet(simulation.world_info(), options));
  cloth.setVelocity(btVector3(0, -40, 0));
  Shot impact;
  for (int step = 0; step < 30; ++step) {
    simulation.step(kStep);
    for (int i = 0; i < cloth.m_nodes.size(); ++i) impact.highest = btMax(impact.highest, cloth.m_nodes[i].m_x.y());
  }
  for (int i = 0; i < cloth.m_nodes.size(); ++i) impact.through += cloth.m_nodes[i].m_x.y() < 0;
  return impact;
}

TEST_P(PluggedIn, nothing_passes_through_at_40_metres_per_second) {
  const Shot impact = shoot(GetParam(), Detection::ccd);
  EXPECT_EQ(impact.through, 0);
  EXPECT_LT(impact.highest, 1) << "the cloth was thrown back";
}

TEST(Bullet, lets_a_fast_cloth_through) {
  EXPECT_GT(shoot(PlugIn::none, Detection::dcd).through, 100);
}

/// The greatest energy of vertical motion of two sheets that fly along together, a quarter of a metre above each other,
/// and approach each other slowly, by 0.1 m in all.
double vertical_energy_side_by_side(PlugIn plug_in) {
  Simulation simulation(plug_in, test_settings());
  simulation.world_info().m_gravity.setZero();
  std::vector<btSoftBody*> sheets;
  for (const btScalar height : {btScalar(0), btScalar(0.25)}) {
    SheetOptions options;
    options.height = height;
    sheets.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
    sheets.back()->addVelocity(btVector3(15, height > 0 ? btScalar(-0.6) : btScalar(0), 0));
  }
  double highest = 0;
  for (int step = 0; step < 10; ++step) {
    simulation.step(kStep);
    double energy = 0;
    for (const btSoftBody* sheet : sheets) {
      for (int i = 0; i < sheet->m_nodes.size(); ++i) {
        const btSoftBody::Node& node = sheet->m_nodes[i];
        energy += double(node.m_v.y() * node.m_v.y() / node.m_im) / 2;
      }
    }
    highest = std::max(highest, energy);
  }
  return highest;
}

TEST(Bullet, does_not_throw_apart_what_flies_side_by_side) {
  EXPECT_LT(vertical_energy_side_by_side(PlugIn::none), 0.2);
}

// Bullet's margin grows by all of a node's motion, but its trees do not find features sideways of it.
TEST_P(PluggedIn, what_flies_side_by_side_is_not_thrown_apart) {
  EXPECT_LT(vertical_energy_side_by_side(GetParam()), 0.2);
}

// Bullet's soft-rigid test reads the node trees that softcd does not update until they are needed.
TEST_P(PluggedIn, a_cloth_rests_on_a_rigid_box_as_with_bullet) {
  const auto rest_height = [](PlugIn plug_in) {
    Simulation simulation(plug_in, test_settings());
    simulation.add_static_box(btVector3(2, btScalar(0.5), 2), btVector3(0, btScalar(-0.5), 0));
    SheetOptions options;
    options.height = btScalar(0.6);
    btSoftBody& cloth = simulation.add(make_sheet(simulation.world_info(), options));
    cloth.m_cfg.kKHR = 1;
    std::size_t contacts = 0;
    for (int step = 0; step < 120; ++step) {
      simulation.step(kStep);
      contacts += static_cast<std::size_t>(cloth.m_rcontacts.size());
    }
    EXPECT_GT(contacts, 1000U);
    return mean_height(cloth);
  };
  EXPECT_NEAR(rest_height(GetParam()), rest_height(PlugIn::none), 0.005);
}

// On the CPU that means the same twice.
TEST_P(PluggedIn, runs_the_same_on_every_backend) {
  const auto positions = [](PlugIn plug_in, Backend backend) {
    SceneOptions options = scene_options(Collision::softcd, plug_in, Detection::ccd, 12);
    options.settings.backend = backend;
    TwoCloths scene(options);
    run(scene, 0.75);
    std::vector<btScalar> heights;
    heights.reserve(static_cast<std::size_t>(scene.upper().m_nodes.size()));
    for (int i = 0; i < scene.upper().m_nodes.size(); ++i) heights.push_back(scene.upper().m_nodes[i].m_x.y());
    return heights;
  };
  EXPECT_EQ(positions(GetParam(), backend_under_test()), positions(GetParam(), Backend::cpu));
}

TEST_P(PluggedIn, the_backend_under_test_detects) {
  Simulation simulation(GetParam(), test_settings());
  for (int sheet = 0; sheet < 2; ++sheet) simulation.add(make_sheet(simulation.world_info(), {}));
  simulation.step(kStep);
  EXPECT_GT(simulation.detection()->contact_report().statistics().vt_contacts, 0U);
  EXPECT_EQ(simulation.detection()->contact_report().statistics().backend, backend_under_test());
}

TEST_P(PluggedIn, worlds_do_not_disturb_each_other) {
  const auto make = [](PlugIn plug_in) {
    return std::make_unique<TwoCloths>(scene_options(Collision::softcd, plug_in, Detection::dcd, 12));
  };
  const auto alone = make(GetParam());
  run(*alone, 0.5);
  const auto one = make(GetParam());
  const auto other = make(GetParam());
  for (int step = 0; double(one->time()) < 0.5; ++step) {
    one->step();
    if (step % 2 == 0) other->step();
  }
  EXPECT_EQ(mean_height(one->upper()), mean_height(alone->upper()));
  EXPECT_EQ(one->count_contacts(), alone->count_contacts());
}

}  // namespace
}  // namespace softcd::test
