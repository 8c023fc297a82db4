#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "overlapping.hpp"
#include "reference_distance.hpp"
#include "softcd/math/closest_point.hpp"

// Compares the triangles that spheres and boxes overlap with every single triangle.
namespace softcd::test {
namespace {

TEST(Overlaps, of_spheres_are_triangles_within_their_radius) {
  const auto make = [](Random& random, double extent, const std::vector<PlacedTriangle>& triangles) {
    std::vector<ProbeSphere> spheres;
    for (int i = 0; i < 150; ++i) {
      spheres.push_back({random.in_box(1.2 * extent), random.uniform(0, 0.5) * extent});
      spheres.push_back({triangles[random.below(static_cast<std::uint32_t>(triangles.size()))].x[random.below(3)], 0});
    }
    return spheres;
  };
  const auto judge = [](const ProbeSphere& sphere, const PlacedTriangle& t, double /*extent*/) {
    const ClosestPoints<double> points = closest_points_vertex_triangle(sphere.centre, t.x[0], t.x[1], t.x[2]);
    const double squared = points.squared_distance / points.scale / points.scale;
    return squared <= sphere.radius * sphere.radius ? Verdict::overlapping : Verdict::apart;
  };
  EXPECT_GT(compare_overlaps(3, make, judge), 2500U);
}

/// Returns the distance by the triangle's and the segment's features in long double. A segment that passes through the
/// triangle is replaced by its two parts on both sides of the plane.
long double distance_of(const ProbeCapsule& capsule, const PlacedTriangle& t) {
  const Vec3d normal = cross(t.x[1] - t.x[0], t.x[2] - t.x[0]);
  const double from = dot(normal, capsule.from - t.x[0]);
  const double to = dot(normal, capsule.to - t.x[0]);
  long double least = std::min(distance_vertex_triangle(capsule.from, t.x[0], t.x[1], t.x[2]),
                               distance_vertex_triangle(capsule.to, t.x[0], t.x[1], t.x[2]));
  if (from * to < 0) {
    const Vec3d through = lerp(capsule.from, capsule.to, from / (from - to));
    least = std::min(least, distance_vertex_triangle(through, t.x[0], t.x[1], t.x[2]));
  }
  for (int i = 0; i < 3; ++i) {
    least = std::min(least, distance_edge_edge(capsule.from, capsule.to, t.x[i], t.x[(i + 1) % 3]));
  }
  return least;
}

TEST(Overlaps, of_capsules_are_triangles_within_their_radius_of_the_segment) {
  const auto make = [](Random& random, double extent, const std::vector<PlacedTriangle>& /*triangles*/) {
    std::vector<ProbeCapsule> capsules;
    for (int i = 0; i < 150; ++i) {
      const Vec3d from = random.in_box(1.2 * extent);
      const Vec3d to = i % 10 == 0 ? from : from + std::exp2(random.uniform(-5, 3)) * extent * random.direction();
      capsules.push_back({from, to, i % 7 == 0 ? 0.0 : std::exp2(random.uniform(-8, -1)) * extent});
    }
    return capsules;
  };
  const auto judge = [](const ProbeCapsule& capsule, const PlacedTriangle& t, double extent) {
    return verdict_on(static_cast<double>(distance_of(capsule, t)) - capsule.radius, 1e-11 * extent);
  };
  EXPECT_GT(compare_overlaps(6, make, judge), 2500U);
}

TEST(Overlaps, of_capsules_without_a_radius_are_what_the_segment_passes_through) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<ProbeCapsule> capsules = {
      {{0.3, 0.4, -1}, {0.3, 0.4, 1}, 0}, {{0.3, 0.4, 0.5}, {0.3, 0.4, 1}, 0}, {{0.3, 0.4, -1e30}, {0.3, 0.4, 1e30}, 0},
      {{kNaN, 0, 0}, {0, 0, 0}, 1},       {{0, 0, 0}, {0, kNaN, 0}, 1},        {{0, 0, 0}, {0, 0, 0}, -1},
      {{0, 0, 0}, {0, 0, 0}, kNaN},       {{0, 0, 0}, {1e38, 0, 0}, 1},        {{9, 9, 9}, {9, 9, 9}, kInfinity}};
  const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(capsules);
  EXPECT_EQ(found[0].size(), 1U);
  EXPECT_EQ(found[1].size(), 0U);
  EXPECT_GE(found[2].size(), 1U);
  for (std::size_t i = 3; i < 8; ++i) EXPECT_TRUE(found[i].empty()) << "capsule " << i;
  EXPECT_EQ(found[8].size(), probed.bodies[0].triangles.size());
}

std::vector<HalfSpace> sides_of(const ProbeBox& box) {
  return {{{1, 0, 0}, box.hi.x},   {{0, 1, 0}, box.hi.y},   {{0, 0, 1}, box.hi.z},
          {{-1, 0, 0}, -box.lo.x}, {{0, -1, 0}, -box.lo.y}, {{0, 0, -1}, -box.lo.z}};
}

TEST(Overlaps, of_boxes_are_triangles_that_are_partly_inside) {
  const auto make = [](Random& random, double extent, const std::vector<PlacedTriangle>& /*triangles*/) {
    std::vector<ProbeBox> boxes;
    for (int i = 0; i < 200; ++i) {
      const Vec3d centre = random.in_box(1.2 * extent);
      const double size = std::exp2(random.uniform(-6, 0)) * extent;
      const Vec3d half{size * random.unit(), size * random.unit(), size * random.unit()};
      boxes.push_back({centre - half, centre + half});
    }
    return boxes;
  };
  const auto judge = [](const ProbeBox& box, const PlacedTriangle& t, double extent) {
    return verdict_on(t, sides_of(box), 1e-12 * extent);
  };
  EXPECT_GT(compare_overlaps(4, make, judge), 3000U);
}

/// Columns of a rotation, of random unit quaternions, or of a quarter turn.
std::array<Vec3d, 3> random_axes(Random& random) {
  if (random.below(4) == 0) return {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  Vec3d a = random.in_box(1);
  Vec3d b = random.in_box(1);
  a = (1.0 / std::sqrt(squared_norm(a))) * a;
  b = b - dot(a, b) * a;
  b = (1.0 / std::sqrt(squared_norm(b))) * b;
  return {a, b, cross(a, b)};
}

/// Returns the triangle in the box's coordinates.
PlacedTriangle seen_from(const ProbeOrientedBox& box, PlacedTriangle triangle) {
  for (Vec3d& x : triangle.x) {
    const Vec3d offset = x - box.centre;
    x = {dot(box.axes[0], offset), dot(box.axes[1], offset), dot(box.axes[2], offset)};
  }
  return triangle;
}

TEST(Overlaps, of_turned_boxes_are_triangles_that_are_partly_inside) {
  const auto make = [](Random& random, double extent, const std::vector<PlacedTriangle>& /*triangles*/) {
    std::vector<ProbeOrientedBox> boxes;
    for (int i = 0; i < 200; ++i) {
      const double size = std::exp2(random.uniform(-6, 0)) * extent;
      const std::array<Vec3d, 3> axes = random_axes(random);
      const double thickness = i % 10 == 0 ? 0.0 : random.unit();
      boxes.push_back({random.in_box(1.2 * extent),
                       {size * random.unit(), size * thickness, size * random.unit()},
                       {axes[0], axes[1], axes[2]}});
    }
    return boxes;
  };
  const auto judge = [](const ProbeOrientedBox& box, const PlacedTriangle& t, double extent) {
    return verdict_on(seen_from(box, t), sides_of({-1.0 * box.half, box.half}), 1e-11 * extent);
  };
  EXPECT_GT(compare_overlaps(5, make, judge), 3000U);
}

TEST(Overlaps, of_shapes_without_end_are_all) {
  const Vec3d distant = {kInfinity, kInfinity, kInfinity};
  const ProbeSphere sphere = {{0, 0, 0}, kInfinity};
  const ProbeBox box = {-distant, distant};
  const ProbeOrientedBox turned = {{0, 0, 0}, distant};
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    ProbedBodies probed(std::move(named.bodies));
    const std::size_t all = placed_triangles(probed).size();
    EXPECT_EQ(probed.probe.overlaps({&sphere, 1})[0].size(), all);
    EXPECT_EQ(probed.probe.overlaps({&box, 1})[0].size(), all);
    EXPECT_EQ(probed.probe.overlaps({&turned, 1})[0].size(), all);
  }
}

TEST(Overlaps, of_no_turned_box_are_none) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<ProbeOrientedBox> boxes = {{{0, 0, 0}, {1, 1, 0}},
                                               {{0, kNaN, 0}, {1, 1, 0}},
                                               {{0, 0, 0}, {1, 1, kNaN}},
                                               {{0, 0, 0}, {1, -1, 1}},
                                               {{0, 0, 0}, {1, 1, 1}, {{1, 0, 0}, {0, kNaN, 0}, {0, 0, 1}}},
                                               {{1e38, 0, 0}, {1e39, 1e39, 1e39}}};
  const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(boxes);
  EXPECT_FALSE(found[0].empty());
  for (std::size_t i = 1; i < boxes.size(); ++i) EXPECT_TRUE(found[i].empty()) << "box " << i;
}

TEST(Overlaps, of_no_shape_are_none) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<ProbeSphere> spheres = {
      {{0, 0, 0}, 1}, {{kNaN, 0, 0}, 1}, {{0, 0, 0}, kNaN}, {{0, 0, 0}, -1}, {{1e38, 0, 0}, 1e39}};
  const AnswerLists<TriangleOverlap> in_spheres = probed.probe.overlaps(spheres);
  EXPECT_FALSE(in_spheres[0].empty());
  for (std::size_t i = 1; i < spheres.size(); ++i) EXPECT_TRUE(in_spheres[i].empty()) << "sphere " << i;
  const std::vector<ProbeBox> boxes = {
      {{-1, -1, 0}, {1, 1, 0}}, {{-1, kNaN, 0}, {1, 1, 0}}, {{-1, -1, 0}, {1, 1, kNaN}}, {{1, -1, 0}, {-1, 1, 0}}};
  const AnswerLists<TriangleOverlap> in_boxes = probed.probe.overlaps(boxes);
  EXPECT_FALSE(in_boxes[0].empty());
  for (std::size_t i = 1; i < boxes.size(); ++i) EXPECT_TRUE(in_boxes[i].empty()) << "box " << i;
}

}  // namespace
}  // namespace softcd::test
