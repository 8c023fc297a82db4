#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "expectations.hpp"
#include "fans.hpp"
#include "mesh_generators.hpp"
#include "softcd/mesh/features.hpp"

// Triangles of one body that share a vertex: their features are listed once, not found again.
namespace softcd::test {
namespace {

/// Returns a mesh so rough that triangles that share a vertex touch in many places.
Mesh rough_mesh() {
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
  const Scene nearby{still(rough_mesh(), everything(0.04F))};
  expect_discrete_contacts(nearby, test_options(Detection::dcd));
  EXPECT_GT(count_neighbours(nearby[0], detect_once(nearby, test_options(Detection::dcd))), 50U);
  const Scene passing{in_motion(rough_mesh(), 0.0F)};
  expect_continuous_contacts(passing, test_options(Detection::ccd));
  EXPECT_GT(count_neighbours(passing[0], detect_once(passing, test_options(Detection::ccd))), 10U);
}

TEST(Neighbours, around_a_vertex_of_many_triangles) {
  std::size_t count = 0;
  for (const NamedFan& fan : fans(120)) {
    SCOPED_TRACE(fan.name);
    // Margins of 0, and margins for which features are in contact at distances below, about and above the edges of the
    // rim.
    for (const float margin : {0.0F, 0.01F, 0.05F, 0.2F}) {
      count += expect_discrete_contacts({still(fan.mesh, everything(margin))}, test_options(Detection::dcd));
    }
  }
  EXPECT_GT(count, 100000U);
}

TEST(Neighbours, around_a_vertex_of_many_triangles_on_their_way) {
  std::size_t count = 0;
  for (const NamedFan& fan : fans(72)) {
    SCOPED_TRACE(fan.name);
    Positions3 x_t1 = translated(jittered(fan.mesh.positions, 0.1, 9), {0.5, 0.25, 4.0});
    snap_to_grid(x_t1, 20);
    count +=
        expect_continuous_contacts({moving(fan.mesh, std::move(x_t1), everything())}, test_options(Detection::ccd));
  }
  EXPECT_GT(count, 500U);
}

TEST(Neighbours, around_a_vertex_come_within_their_margin_on_their_way) {
  PipelineOptions options = test_options(Detection::ccd);
  options.accuracy = Accuracy::conservative;
  for (const NamedFan& fan : fans(72)) {
    SCOPED_TRACE(fan.name);
    Positions3 x_t1 = jittered(fan.mesh.positions, 0.2, 10);
    snap_to_grid(x_t1, 20);
    const Scene scene{moving(fan.mesh, std::move(x_t1), everything(0.02F))};
    const std::vector<Contact> contacts = detect_once(scene, options);
    EXPECT_GT(contacts.size(), 40U);
    expect_nothing_missed_on_the_way(scene, contacts);
  }
}

// Around a vertex n triangles make n^2 / 2 pairs whose volumes overlap.
TEST(Neighbours, around_a_vertex_are_tested_only_with_those_near_them) {
  constexpr std::uint32_t kCount = 1000;
  std::vector<NamedFan> tame_fans = fans(kCount);
  tame_fans.pop_back();  // those of the star do cross each other
  for (const NamedFan& fan : tame_fans) {
    SCOPED_TRACE(fan.name);
    const Statistics still_fan = outcome_of({still(fan.mesh, everything())}, test_options(Detection::dcd)).statistics;
    EXPECT_LT(still_fan.triangle_pairs, 5 * kCount);
    Positions3 x_t1 = translated(jittered(fan.mesh.positions, 1e-4, 11), {0, 0, 1});
    const Statistics moving_fan =
        outcome_of({moving(fan.mesh, std::move(x_t1), everything())}, test_options(Detection::ccd)).statistics;
    EXPECT_LT(moving_fan.triangle_pairs, 5 * kCount);
  }
}

TEST(Neighbours, follow_the_settings) {
  const Scene scene{in_motion(rough_mesh(), 0.02F), still(moved(rough_mesh(), {0.1, 0.2, 0.3}), everything(0.02F))};
  LoadedScene loaded = load(scene, test_options(Detection::ccd));
  const auto expect_same_as_anew = [&](const BodySettings& settings) {
    loaded.scene[0].settings = settings;
    loaded.pipeline.scene.set_settings(loaded.ids[0], settings);
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
  Scene scene{still(rough_mesh(), everything(0.04F))};
  const std::vector<Contact> whole = detect_once(scene, test_options(Detection::dcd));
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  loaded.pipeline.detect();

  Positions3 torn = scene[0].x_t1;
  for (std::size_t v = 0; v < torn.size(); v += 9) torn[v].y = NAN;
  scene[0].x_t1 = scene[0].x_t0 = torn;
  loaded.pipeline.scene.set_positions(loaded.ids[0], Span<const Vec3d>(torn));
  const std::vector<Contact> anew = detect_once(scene, test_options(Detection::dcd));
  EXPECT_GT(anew.size(), 50U);
  EXPECT_LT(anew.size(), whole.size());
  EXPECT_TRUE(identical(loaded.pipeline.detect(), anew));

  loaded.pipeline.scene.set_positions(loaded.ids[0], Span<const Vec3d>(loaded.scene[0].x_t1));
  EXPECT_TRUE(identical(loaded.pipeline.detect(), whole));
}

}  // namespace
}  // namespace softcd::test
