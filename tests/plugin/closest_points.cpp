#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "probing.hpp"
#include "softcd/math/closest_point.hpp"

// Compares nearest points of a scene with every single triangle.
namespace softcd::test {
namespace {

std::vector<ProbePoint> many_points(const std::vector<PlacedTriangle>& triangles, double extent, std::uint64_t seed) {
  Random random(seed);
  std::vector<ProbePoint> points;
  for (int i = 0; i < 150; ++i) {
    const auto& x = triangles[random.below(static_cast<std::uint32_t>(triangles.size()))].x;
    const Vec3d on_edge = lerp(x[0], x[1], random.unit());
    points.push_back({random.in_box(1.5 * extent)});
    points.push_back({random.in_box(1.5 * extent), random.uniform(0, extent)});
    points.push_back({x[random.below(3)]});
    points.push_back({on_edge + std::exp2(random.uniform(-30, 0)) * extent * random.direction()});
    points.push_back({1e4 * random.in_box(extent)});
  }
  return points;
}

struct Nearest {
  BodyId body;
  std::uint32_t triangle = kNoIndex;
  double distance = kInfinity;
};

Nearest nearest_of_all(const std::vector<PlacedTriangle>& triangles, const ProbePoint& point) {
  Nearest best;
  double best_squared = point.max_distance * point.max_distance;
  for (const PlacedTriangle& triangle : triangles) {
    const ClosestPoints<double> points =
        closest_points_vertex_triangle(point.point, triangle.x[0], triangle.x[1], triangle.x[2]);
    const double squared = points.squared_distance / points.scale / points.scale;
    if (squared < best_squared || (squared == best_squared && best.triangle == kNoIndex)) {
      best_squared = squared;
      best = {triangle.body, triangle.index, points.distance()};
    }
  }
  return best;
}

TEST(ClosestPoints, are_nearest_of_all_triangles) {
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    const std::vector<ProbePoint> points = many_points(triangles, extent, 9);
    const Span<const ClosestPoint> found = probed.probe.closest_points(points);
    ASSERT_EQ(found.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Nearest expected = nearest_of_all(triangles, points[i]);
      ASSERT_EQ(found[i].has_point(), expected.triangle != kNoIndex) << "point " << i;
      if (!found[i].has_point()) continue;
      ASSERT_EQ(found[i].distance, expected.distance) << "point " << i;
      ASSERT_EQ(found[i].body, expected.body) << "point " << i;
      ASSERT_EQ(found[i].triangle, expected.triangle) << "point " << i;
      ASSERT_LE(found[i].distance, points[i].max_distance * (1 + 1e-15));
    }
  }
}

TEST(ClosestPoints, tell_where_they_are) {
  ProbedBodies probed({still(crumpled_cloth(12, 10, 0.25, 0.1, 3), {}), still(outward_ball(2, 1.0), {})});
  const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
  const std::vector<ProbePoint> points = many_points(triangles, 2, 10);
  const Span<const ClosestPoint> found = probed.probe.closest_points(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ClosestPoint& closest = found[i];
    if (!closest.has_point()) continue;
    const SceneBody& body = probed.bodies[closest.body.value];
    const auto& v = body.triangles[closest.triangle].v;
    Vec3d by_weights{0, 0, 0};
    double sum = 0;
    for (int corner = 0; corner < 3; ++corner) {
      EXPECT_GE(closest.weights[corner], 0);
      EXPECT_LE(closest.weights[corner], 1);
      by_weights =
          by_weights + double(closest.weights[corner]) * vec3_cast<double>(vec3_cast<float>(body.x_t1[v[corner]]));
      sum += double(closest.weights[corner]);
    }
    const double tolerance = 1e-6 + 1e-12 * norm(points[i].point);
    EXPECT_NEAR(sum, 1, 1e-6);
    EXPECT_LT(norm(by_weights - closest.position), tolerance) << "point " << i;
    EXPECT_NEAR(norm(points[i].point - closest.position), closest.distance, tolerance) << "point " << i;
  }
}

TEST(ClosestPoints, of_what_is_no_point_are_none) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<ProbePoint> points = {
      {{0.3, 0.3, 1}},        {{kNaN, 0, 0}},     {{0, kInfinity, 0}}, {{0.3, 0.3, 1}, kNaN}, {{0.3, 0.3, 1}, -1},
      {{0.3, 0.3, 1}, 0.999}, {{0.3, 0.3, 1}, 1}, {{0.3, 0.3, 0}, 0},  {{1e38, 0, 0}},        {{0.3, 0.3, 1e30}, 1e31}};
  const std::vector<bool> expected = {true, false, false, false, false, false, true, true, false, true};
  const Span<const ClosestPoint> found = probed.probe.closest_points(points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(found[i].has_point(), expected[i]) << "point " << i;
}

/// Returns the winding number of the surface around the point, by solid angles (van Oosterom and Strackee 1983).
double winding_number(const std::vector<PlacedTriangle>& triangles, Vec3d p) {
  double sum = 0;
  for (const PlacedTriangle& triangle : triangles) {
    const Vec3d a = triangle.x[0] - p;
    const Vec3d b = triangle.x[1] - p;
    const Vec3d c = triangle.x[2] - p;
    const double volume = dot(a, cross(b, c));
    const double below = norm(a) * norm(b) * norm(c) + dot(a, b) * norm(c) + dot(b, c) * norm(a) + dot(c, a) * norm(b);
    sum += 2 * std::atan2(volume, below);
  }
  return sum / (4 * std::numbers::pi);
}

/// Returns a star of needles: at the tips, normals of single triangles point to the wrong side.
Mesh spiky_ball() {
  Mesh mesh = outward_ball(1, 0.25);
  Random random(6);
  for (Vec3d& x : mesh.positions) x = random.uniform(0.5, 6) * x;
  snap_to_grid(mesh.positions, 17);
  return mesh;
}

TEST(ClosestPoints, know_the_inside_of_closed_surfaces) {
  Mesh ring = torus(1.0, 0.4, 20, 12);
  snap_to_grid(ring.positions, 17);
  for (Triangle& t : ring.triangles) std::swap(t.v[0], t.v[1]);  // outwards
  for (const Mesh& mesh : {spiky_ball(), ring}) {
    ProbedBodies probed({still(mesh, {})});
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    std::vector<ProbePoint> points = many_points(triangles, 1, 12);
    // Beyond vertices and edges, near and far.
    Random random(13);
    for (const PlacedTriangle& triangle : triangles) {
      points.push_back({triangle.x[0] + random.uniform(0, 0.2) * random.direction()});
      points.push_back({1.01 * triangle.x[1]});
    }
    const Span<const ClosestPoint> found = probed.probe.closest_points(points);
    int counts[3] = {0, 0, 0};
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!found[i].has_point() || (found[i].distance < 1e-9 && found[i].distance > 0)) continue;
      ++counts[found[i].side + 1];
      if (found[i].distance == 0) {
        EXPECT_EQ(found[i].side, 0);
        continue;
      }
      const int expected = winding_number(triangles, points[i].point) > 0.5 ? -1 : 1;
      ASSERT_EQ(found[i].side, expected) << "point " << i << " at " << found[i].distance;
    }
    EXPECT_GT(counts[0], 50);
    EXPECT_GT(counts[1], 50);
    EXPECT_GT(counts[2], 50);
  }
}

TEST(ClosestPoints, know_no_side_of_what_is_not_closed) {
  const auto side_of = [](const Mesh& mesh) {
    ProbedBodies probed({still(mesh, {})});
    return probed.probe.closest_point({{0.01, 0.02, 0.03}}).side;
  };
  const Mesh ball = outward_ball(1, 1.0);
  EXPECT_EQ(side_of(ball), -1);
  EXPECT_EQ(side_of(joined(ball, moved(ball, {5, 0, 0}))), -1);
  Mesh inside_out = ball;
  for (Triangle& t : inside_out.triangles) std::swap(t.v[0], t.v[1]);
  EXPECT_EQ(side_of(inside_out), 1);
  Mesh open = ball;
  open.triangles.pop_back();
  EXPECT_EQ(side_of(open), 0);
  Mesh twisted = ball;
  std::swap(twisted.triangles[5].v[0], twisted.triangles[5].v[1]);
  EXPECT_EQ(side_of(twisted), 0);
  Mesh doubled = ball;
  doubled.triangles.push_back(ball.triangles[0]);
  EXPECT_EQ(side_of(doubled), 0);
  Mesh with_needle = ball;
  with_needle.triangles.push_back({{0, 0, 1}});
  EXPECT_EQ(side_of(with_needle), 0);
  // Two balls that share one vertex.
  Mesh pinched = joined(ball, moved(ball, {5, 0, 0}));
  for (Triangle& t : pinched.triangles) {
    for (std::uint32_t& v : t.v) v = v == ball.positions.size() ? 0 : v;
  }
  EXPECT_EQ(side_of(pinched), 0);
  EXPECT_EQ(side_of(grid_cloth(3, 3, 1.0)), 0);
  // The surface is closed again once the vertex is finite again.
  ProbedBodies probed({still(ball, {})});
  Positions3 broken = ball.positions;
  broken[3].y = kNaN;
  probed.scene.set_positions(probed.ids[0], broken);
  EXPECT_EQ(probed.probe.closest_point({{0, 0, 0}}).side, 0);
  probed.scene.set_positions(probed.ids[0], ball.positions);
  EXPECT_EQ(probed.probe.closest_point({{0, 0, 0}}).side, -1);
}

// A spike with one side of many slivers, whose normals together would turn that of its tip to their side.
TEST(ClosestPoints, know_the_side_at_a_tip_of_many_slivers) {
  constexpr std::uint32_t kSlivers = 40;
  Mesh spike{{}, {{0, 0, 0}}};
  const auto below = [&spike](double x, double y) {
    spike.positions.push_back({x, y, -1.0});
    return static_cast<std::uint32_t>(spike.positions.size() - 1);
  };
  for (std::uint32_t i = 0; i <= kSlivers; ++i) below(0.25, -0.25 + 0.5 * static_cast<double>(i) / kSlivers);
  const std::uint32_t back = below(-0.25, 0.0);
  const std::uint32_t last = kSlivers + 1;
  for (std::uint32_t i = 1; i < last; ++i) {
    spike.triangles.push_back({{0, i, i + 1}});
    spike.triangles.push_back({{back, i + 1, i}});
  }
  spike.triangles.push_back({{0, last, back}});
  spike.triangles.push_back({{0, back, 1}});
  ProbedBodies probed({still(spike, {})});
  EXPECT_EQ(probed.probe.closest_point({{0, 0, -0.5}}).side, -1);
  EXPECT_EQ(probed.probe.closest_point({{0.1, 0, 0.1}}).side, 1);
  EXPECT_EQ(probed.probe.closest_point({{-0.1, 0, 0.04}}).side, 1);
  EXPECT_EQ(probed.probe.closest_point({{-0.1, 0, 0.03}}).side, 1);
}

}  // namespace
}  // namespace softcd::test
