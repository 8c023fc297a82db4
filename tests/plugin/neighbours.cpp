#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

// Triangles of one body that share a vertex: their features are listed once, not found anew.
namespace softcd::test {
namespace {

/// Rough enough for what shares a vertex to touch in many places.
Mesh rough_cloth() {
  Mesh mesh = crumpled_cloth(16, 12, 0.25, 0.5, 7);
  mesh.positions = jittered(mesh.positions, 0.2, 8);
  snap_to_grid(mesh.positions, 17);
  return mesh;
}

SceneBody in_motion(const Mesh& mesh, float margin) {
  Positions3 x_t1 = jittered(mesh.positions, 0.3, 9);
  snap_to_grid(x_t1, 17);
  return moving(mesh, std::move(x_t1), everything(margin));
}

bool are_neighbours(const std::vector<Triangle>& triangles, const Contact& contact) {
  const auto touches = [&](const Triangle& triangle) {
    return std::find(triangle.v, triangle.v + 3, contact.vertices[0]) != triangle.v + 3;
  };
  return std::any_of(triangles.begin(), triangles.end(), [&](const Triangle& triangle) {
    return touches(triangle) && share_vertex(triangle, triangles[contact.feature_b]);
  });
}

std::size_t count_neighbours(const SceneBody& body, const std::vector<Contact>& contacts) {
  return static_cast<std::size_t>(std::count_if(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    return contact.kind == ContactKind::vertex_triangle && are_neighbours(body.triangles, contact);
  }));
}

TEST(Neighbours, touch_as_everything_else_does) {
  const Scene near{still(rough_cloth(), everything(0.04F))};
  expect_discrete_contacts(near, test_options(Detection::dcd));
  EXPECT_GT(count_neighbours(near[0], detect_once(near, test_options(Detection::dcd))), 50U);
  const Scene passing{in_motion(rough_cloth(), 0.0F)};
  expect_continuous_contacts(passing, test_options(Detection::ccd));
  EXPECT_GT(count_neighbours(passing[0], detect_once(passing, test_options(Detection::ccd))), 10U);
}

// Too many around one vertex to be listed.
TEST(Neighbours, around_a_vertex_of_many_triangles) {
  Mesh fan{{}, {{0, 0, 0}}};
  constexpr std::uint32_t kCount = 150;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double angle = 2 * M_PI * i / kCount;
    fan.positions.push_back({std::cos(angle), std::sin(angle), 0.02 * (i % 7)});
    fan.triangles.push_back({{0, 1 + i, 1 + (i + 1) % kCount}});
  }
  snap_to_grid(fan.positions, 17);
  EXPECT_GT(expect_discrete_contacts({still(fan, everything(0.05F))}, test_options(Detection::dcd)), 100U);
  EXPECT_GT(expect_continuous_contacts({in_motion(fan, 0.0F)}, test_options(Detection::ccd)), 50U);
}

TEST(Neighbours, follow_the_settings) {
  const Scene scene{in_motion(rough_cloth(), 0.02F), still(moved(rough_cloth(), {0.1, 0.2, 0.3}), everything(0.02F))};
  LoadedScene loaded = load(scene, test_options(Detection::ccd));
  const auto expect_same_as_anew = [&](const BodySettings& settings) {
    loaded.scene[0].settings = settings;
    loaded.pipeline.set_settings(loaded.ids[0], settings);
    const std::vector<Contact> anew = detect_once(loaded.scene, test_options(Detection::ccd));
    EXPECT_GT(anew.size(), 100U);
    EXPECT_TRUE(identical(loaded.pipeline.detect(), anew));
  };
  BodySettings settings = everything(0.02F);
  expect_same_as_anew(settings);
  settings.self_collision = false;
  expect_same_as_anew(settings);
  settings.self_collision = true;
  settings.features.edge_edge = false;
  expect_same_as_anew(settings);
  settings.kinematic = true;
  expect_same_as_anew(settings);
  expect_same_as_anew(everything(0.02F));
}

TEST(Neighbours, go_with_triangles_that_are_left_out_and_come_back) {
  Scene scene{still(rough_cloth(), everything(0.04F))};
  const std::vector<Contact> whole = detect_once(scene, test_options(Detection::dcd));
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  loaded.pipeline.detect();

  Positions3 torn = scene[0].x_t1;
  for (std::size_t v = 0; v < torn.size(); v += 9) torn[v].y = NAN;
  scene[0].x_t1 = scene[0].x_t0 = torn;
  loaded.pipeline.set_positions(loaded.ids[0], Span<const Vec3d>(torn));
  const std::vector<Contact> anew = detect_once(scene, test_options(Detection::dcd));
  EXPECT_GT(anew.size(), 50U);
  EXPECT_LT(anew.size(), whole.size());
  EXPECT_TRUE(identical(loaded.pipeline.detect(), anew));

  loaded.pipeline.set_positions(loaded.ids[0], Span<const Vec3d>(loaded.scene[0].x_t1));
  EXPECT_TRUE(identical(loaded.pipeline.detect(), whole));
}

}  // namespace
}  // namespace softcd::test
