// Scenes whose bodies hold each other or themselves. They hold with softcd, and come apart without contacts.

#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/bowline.hpp"
#include "scenes/reef_knot.hpp"
#include "scenes/stack.hpp"
#include "scenes/tube.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using demo::Collision;

demo::SceneOptions scene_options(Collision collision, int size) {
  demo::SceneOptions options;
  options.collision = collision;
  options.settings = careful_settings();
  options.size = size;
  return options;
}

void run(demo::Scene& scene, double seconds) {
  while (double(scene.time()) < seconds) scene.step();
}

/// The least stretch of a leg at which the hands count as stopped by the knot.
constexpr btScalar kPull = btScalar(0.03);

constexpr int kReefKnotSize = 90;
constexpr double kReefKnotIsTight = 5;

TEST(ReefKnot, holds) {
  demo::ReefKnot scene(scene_options(Collision::softcd, kReefKnotSize));
  EXPECT_EQ(scene.count_penetrating_vertices(), 0U);
  const btScalar loose = scene.overlap();
  run(scene, kReefKnotIsTight);
  EXPECT_EQ(scene.count_penetrating_vertices(), 0U);
  EXPECT_GT(scene.stretch(), kPull);
  EXPECT_GT(scene.overlap(), 0.3) << "the ribbon is 0.35 wide";
  EXPECT_LT(scene.overlap(), loose / 2);
}

TEST(ReefKnot, comes_apart_without_contacts_within_and_between_the_ribbons) {
  for (const Collision collision : {Collision::bullet, Collision::off}) {
    demo::ReefKnot scene(scene_options(collision, kReefKnotSize));
    run(scene, kReefKnotIsTight);
    EXPECT_LT(scene.stretch(), kPull);
    EXPECT_LT(scene.overlap(), -0.5);
  }
}

constexpr int kBowlineSize = 150;
constexpr double kBowlineIsTight = 6;

TEST(Bowline, holds) {
  demo::Bowline scene(scene_options(Collision::softcd, kBowlineSize));
  EXPECT_EQ(scene.count_penetrating_vertices(), 0U);
  run(scene, kBowlineIsTight);
  EXPECT_EQ(scene.count_penetrating_vertices(), 0U);
  EXPECT_GT(scene.stretch(), kPull);
  const btScalar standing_end = scene.standing_end();
  run(scene, kBowlineIsTight + 1);
  EXPECT_LT(scene.standing_end() - standing_end, 1) << "the hand moves 3 a second unless the knot holds it back";
  EXPECT_LT(scene.free_end(), 1.5) << "it sticks out of the knot, which begins at 2";
}

TEST(Bowline, comes_undone_without_contacts_within_the_ribbon) {
  for (const Collision collision : {Collision::bullet, Collision::off}) {
    demo::Bowline scene(scene_options(collision, kBowlineSize));
    run(scene, kBowlineIsTight + 1);
    EXPECT_GT(scene.standing_end(), 14) << "the held one's is at 12";
  }
}

double mean_height_above(demo::Stack& scene, int number) {
  return double(mean_height(scene.cloth(number)) - mean_height(scene.cloth(number - 1)));
}

TEST(Stack, keeps_its_order) {
  demo::Stack scene(scene_options(Collision::softcd, 12));
  run(scene, 2);
  EXPECT_EQ(scene.count_penetrating_vertices(), 0U);
  for (int number = 1; number < demo::Stack::kCloths; ++number) EXPECT_GT(mean_height_above(scene, number), 0);
}

TEST(Stack, falls_through_itself_without_contacts) {
  demo::Stack scene(scene_options(Collision::off, 12));
  run(scene, 2);
  EXPECT_GT(scene.count_penetrating_vertices(), 100U);
}

constexpr int kTubeSize = 20;
constexpr double kTubeIsFolded = 3;

double height_of(const btSoftBody& body) {
  btScalar highest = 0;
  for (int i = 0; i < body.m_nodes.size(); ++i) highest = std::max(highest, body.m_nodes[i].m_x.y());
  return double(highest);
}

TEST(Tube, lies_in_folds_on_itself) {
  demo::Tube scene(scene_options(Collision::softcd, kTubeSize));
  const double standing = height_of(scene.tube());
  std::size_t most_contacts = 0;
  while (double(scene.time()) < kTubeIsFolded) {
    scene.step();
    most_contacts = std::max(most_contacts, scene.count_contacts());
  }
  const demo::Penetration penetration = scene.count_penetration();
  EXPECT_EQ(penetration.vertices, 0U);
  EXPECT_EQ(penetration.edges, 0U);
  EXPECT_GT(most_contacts, 100U);
  EXPECT_LT(height_of(scene.tube()), 0.5 * standing);
}

TEST(Tube, folds_through_itself_without_contacts) {
  for (const Collision collision : {Collision::bullet, Collision::off}) {
    demo::Tube scene(scene_options(collision, kTubeSize));
    run(scene, kTubeIsFolded);
    EXPECT_GT(scene.count_penetrating_vertices(), 50U);
  }
}

}  // namespace
}  // namespace softcd::test
