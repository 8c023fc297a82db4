// Every scene, small: it moves, stays in one piece, and nothing passes through anything.

#include "scenes/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "scenes/vectors.hpp"

namespace softcd::test {
namespace {

using demo::make_scene;
using demo::Penetration;
using demo::Scene;
using demo::SceneInfo;
using demo::SceneOptions;
using demo::World;

constexpr int kSteps = 60;
constexpr btScalar kFastest = 20;  // gravity gives 5 in that time

const std::map<std::string, int> kSmallSizes = {
    {"n-body", 8}, {"mixed-sizes-balls", 2}, {"mixed-sizes-cloth", 16}, {"flamenco", 12}, {"folding-cloth", 12}};

/// Knots that are loose at the start; their own tests check them when they are tight.
const std::set<std::string> kTouchLater = {"reef-knot"};

/// Pictures show the knot; the ends of its ropes are pulled out of the picture.
const std::set<std::string> kPulledOut = {"reef-knot", "bowline"};

SceneOptions little(const SceneInfo& info, World world) {
  const auto size = kSmallSizes.find(info.name);
  SceneOptions options;
  options.world = world;
  options.size = size == kSmallSizes.end() ? std::max(16, info.smallest_size) : size->second;
  options.settings.backend = Backend::cpu;
  options.settings.detection = Detection::ccd;
  options.settings.edge_contacts = bullet::EdgeContacts::respond;
  return options;
}

TEST(Scenes, refuse_to_be_made_without_a_size) {
  for (const SceneInfo& info : demo::scenes()) {
    EXPECT_THROW(info.make(SceneOptions()), std::invalid_argument) << info.name;
  }
}

struct Motion {
  btScalar fastest = 0;
  btVector3 low{SIMD_INFINITY, SIMD_INFINITY, SIMD_INFINITY};
  btVector3 high = -low;
  bool is_finite = true;
};

Motion motion_of(const Scene& scene) {
  Motion motion;
  for (const demo::Surface& surface : scene.surfaces()) {
    for (int i = 0; i < surface.body->m_nodes.size(); ++i) {
      const btSoftBody::Node& node = surface.body->m_nodes[i];
      motion.fastest = btMax(motion.fastest, node.m_v.length());
      motion.low.setMin(node.m_x);
      motion.high.setMax(node.m_x);
      motion.is_finite &= std::isfinite(node.m_x.length2()) && std::isfinite(node.m_v.length2());
    }
  }
  return motion;
}

class Scenes : public testing::TestWithParam<std::tuple<std::size_t, World>> {
 protected:
  const SceneInfo& info() const { return demo::scenes()[std::get<0>(GetParam())]; }
  World world() const { return std::get<1>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(All, Scenes,
                         testing::Combine(testing::Range(std::size_t{0}, demo::scenes().size()),
                                          testing::Values(World::classic, World::deformable)),
                         [](const auto& parameter) {
                           std::string name = demo::scenes()[std::get<0>(parameter.param)].name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + (std::get<1>(parameter.param) == World::classic ? "_soft" : "_deformable");
                         });

TEST_P(Scenes, stays_in_one_piece_and_apart) {
  if (world() == World::deformable && !info().in_deformable_world) {
    EXPECT_THROW(make_scene(info().name, little(info(), world())), std::invalid_argument);
    return;
  }
  const auto scene = make_scene(info().name, little(info(), world()));
  EXPECT_EQ(scene->count_penetration().edges > 0, info().starts_tangled) << "at the start";
  const Motion start = motion_of(*scene);
  btScalar fastest = 0;
  std::size_t contacts = 0;
  for (int step = 0; step < kSteps; ++step) {
    scene->step();
    const Motion motion = motion_of(*scene);
    ASSERT_TRUE(motion.is_finite) << "step " << step;
    fastest = btMax(fastest, motion.fastest);
    contacts += scene->count_contacts();
  }
  EXPECT_GT(fastest, 0.1);
  EXPECT_LT(fastest, kFastest);
  if (kTouchLater.count(info().name) == 0) {
    EXPECT_GT(contacts, 0U);
  }
  const Motion end = motion_of(*scene);
  EXPECT_LT((end.high - end.low).length(), 1.5 * (start.high - start.low).length());
  for (int step = 0; info().starts_tangled && step < 4 * kSteps; ++step) scene->step();
  const Penetration penetration = scene->count_penetration();
  EXPECT_EQ(penetration.vertices, 0U);
  EXPECT_EQ(penetration.edges, 0U);
  std::cout << info().name << ": fastest " << fastest << ", " << contacts << " contacts\n";
}

/// Returns the largest distance of a node from the middle of a picture of 16 : 9; 1 is the border.
double farthest_from_the_middle(const Scene& scene) {
  constexpr double kAspect = 16.0 / 9.0;
  const demo::View view = scene.view();
  const demo::ViewFrame frame = demo::looking_along(demo::to_vec3d(view.target - view.eye));
  const double half_height = std::tan(double(view.field_of_view) / 2);
  double farthest = 0;
  for (const demo::Surface& surface : scene.surfaces()) {
    for (int i = 0; i < surface.body->m_nodes.size(); ++i) {
      const Vec3d offset = demo::to_vec3d(surface.body->m_nodes[i].m_x - view.eye);
      const double depth = -dot(offset, frame.back);
      if (!(depth > 0)) return std::numeric_limits<double>::infinity();
      const double y = std::abs(dot(offset, frame.up)) / (depth * half_height);
      const double x = std::abs(dot(offset, frame.right)) / (depth * half_height * kAspect);
      farthest = std::max({farthest, x, y});
    }
  }
  return farthest;
}

// For the default number of steps of softcd-demo; those of `refining` take longer and longer.
TEST(Scenes, stay_in_the_picture) {
  for (const SceneInfo& info : demo::scenes()) {
    if (kPulledOut.count(info.name) != 0) continue;
    const auto scene = make_scene(info.name, little(info, World::classic));
    const int steps = info.name == std::string("refining") ? 240 : 600;
    double farthest = farthest_from_the_middle(*scene);
    for (int step = 0; step < steps; ++step) {
      scene->step();
      farthest = std::max(farthest, farthest_from_the_middle(*scene));
    }
    EXPECT_LT(farthest, 1) << info.name;
  }
}

TEST(Scenes, that_have_changed_go_on_in_another_world) {
  for (const char* name : {"tearing", "refining"}) {
    SceneOptions options = little(*demo::find_scene(name), World::classic);
    const auto scene = make_scene(name, options);
    const std::size_t triangles = scene->count_triangles();
    for (int step = 0; step < kSteps; ++step) scene->step();
    EXPECT_GT(scene->count_triangles(), triangles);
    options.collision = demo::Collision::off;
    const auto other = make_scene(name, options);
    other->go_on_from(*scene);
    ASSERT_EQ(other->count_triangles(), scene->count_triangles());
    const btSoftBody& before = *scene->surfaces()[0].body;
    const btSoftBody& after = *other->surfaces()[0].body;
    ASSERT_EQ(after.m_nodes.size(), before.m_nodes.size());
    for (int i = 0; i < before.m_nodes.size(); ++i) EXPECT_EQ(after.m_nodes[i].m_x, before.m_nodes[i].m_x);
    for (int f = 0; f < before.m_faces.size(); ++f) {
      for (int corner = 0; corner < 3; ++corner) {
        EXPECT_EQ(after.m_faces[f].m_n[corner] - &after.m_nodes[0], before.m_faces[f].m_n[corner] - &before.m_nodes[0]);
      }
    }
    for (int step = 0; step < 8; ++step) other->step();
    EXPECT_TRUE(motion_of(*other).is_finite);
  }
}

TEST(Scenes, tell_wrong_names_and_sizes) {
  EXPECT_THROW(make_scene("teapot", {}), std::invalid_argument);
  SceneOptions options;
  options.size = 3;
  EXPECT_THROW(make_scene("cloth-on-ball", options), std::invalid_argument);
  options.size = 16;
  options.collision = demo::Collision::bullet;
  EXPECT_THROW(make_scene("tearing", options), std::invalid_argument);
  EXPECT_EQ(demo::find_scene("teapot"), nullptr);
}

}  // namespace
}  // namespace softcd::test
