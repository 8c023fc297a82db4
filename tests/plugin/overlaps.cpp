#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "overlapping.hpp"
#include "reference_distance.hpp"
#include "softcd/math/closest_point.hpp"

// Triangles that spheres and boxes overlap, against every triangle tried by itself.
namespace softcd::test {
namespace {

TEST(Overlaps, of_spheres_are_triangles_within_their_radius) {
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    Random random(3);
    std::vector<QuerySphere> spheres;
    for (int i = 0; i < 150; ++i) {
      spheres.push_back({random.in_box(1.2 * extent), random.uniform(0, 0.5) * extent});
      spheres.push_back({triangles[random.below(static_cast<std::uint32_t>(triangles.size()))].x[random.below(3)], 0});
    }
    spheres.push_back({{0, 0, 0}, kInfinity});
    const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(spheres);
    ASSERT_EQ(found.size(), spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      expect_in_order(found[i]);
      std::size_t count = 0;
      for (const PlacedTriangle& t : triangles) {
        const ClosestPoints<double> points = closest_points_vertex_triangle(spheres[i].centre, t.x[0], t.x[1], t.x[2]);
        const double squared = points.squared_distance / points.scale / points.scale;
        if (!(squared <= spheres[i].radius * spheres[i].radius)) continue;
        ++count;
        ASSERT_TRUE(has(found[i], t)) << "sphere " << i;
      }
      ASSERT_EQ(found[i].size(), count) << "sphere " << i;
    }
    EXPECT_EQ(found[spheres.size() - 1].size(), triangles.size());
  }
}

/// By the triangle's and the segment's features in long double, but for a segment that passes through the triangle,
/// which is seen by its two parts on both sides of the plane.
long double distance_of(const QueryCapsule& capsule, const PlacedTriangle& t) {
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
  std::size_t certain = 0;
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    Random random(6);
    std::vector<QueryCapsule> capsules;
    for (int i = 0; i < 150; ++i) {
      const Vec3d from = random.in_box(1.2 * extent);
      const Vec3d to = i % 10 == 0 ? from : from + std::exp2(random.uniform(-5, 3)) * extent * random.direction();
      capsules.push_back({from, to, i % 7 == 0 ? 0.0 : std::exp2(random.uniform(-8, -1)) * extent});
    }
    const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(capsules);
    ASSERT_EQ(found.size(), capsules.size());
    for (std::size_t i = 0; i < capsules.size(); ++i) {
      expect_in_order(found[i]);
      for (const PlacedTriangle& t : triangles) {
        const auto gap = static_cast<double>(distance_of(capsules[i], t)) - capsules[i].radius;
        const bool is_found = has(found[i], t);
        if (gap < -1e-11 * extent) {
          ASSERT_TRUE(is_found) << "capsule " << i;
          ++certain;
        } else if (gap > 1e-11 * extent) {
          ASSERT_FALSE(is_found) << "capsule " << i;
        }
      }
    }
  }
  EXPECT_GT(certain, 2500U);
}

TEST(Overlaps, of_capsules_without_a_radius_are_what_the_segment_passes_through) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<QueryCapsule> capsules = {
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

using Wide = Vec3<long double>;

/// What of the polygon is on the inner side of the box's side.
std::vector<Wide> clipped(const std::vector<Wide>& polygon, int axis, long double bound, long double sign) {
  std::vector<Wide> kept;
  const auto depth = [&](const Wide& p) { return sign * (bound - p[axis]); };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Wide& p = polygon[i];
    const Wide& q = polygon[(i + 1) % polygon.size()];
    if (depth(p) >= 0) kept.push_back(p);
    if ((depth(p) >= 0) != (depth(q) >= 0)) kept.push_back(lerp(p, q, depth(p) / (depth(p) - depth(q))));
  }
  return kept;
}

/// Whether something of the triangle is left when all of it outside of the box, grown by so much, is cut off.
bool is_in_box(const PlacedTriangle& triangle, const QueryBox& box, double growth) {
  std::vector<Wide> polygon;
  for (const Vec3d& x : triangle.x) polygon.push_back(vec3_cast<long double>(x));
  for (int axis = 0; axis < 3; ++axis) {
    polygon = clipped(polygon, axis, static_cast<long double>(box.hi[axis]) + growth, 1);
    polygon = clipped(polygon, axis, static_cast<long double>(box.lo[axis]) - growth, -1);
  }
  return !polygon.empty();
}

TEST(Overlaps, of_boxes_are_triangles_that_are_partly_inside) {
  std::size_t certain = 0;
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    Random random(4);
    std::vector<QueryBox> boxes;
    for (int i = 0; i < 200; ++i) {
      const Vec3d centre = random.in_box(1.2 * extent);
      const double size = std::exp2(random.uniform(-6, 0)) * extent;
      const Vec3d half{size * random.unit(), size * random.unit(), size * random.unit()};
      boxes.push_back({centre - half, centre + half});
    }
    boxes.push_back({{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}});
    const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(boxes);
    ASSERT_EQ(found.size(), boxes.size());
    for (std::size_t i = 0; i + 1 < boxes.size(); ++i) {
      expect_in_order(found[i]);
      for (const PlacedTriangle& t : triangles) {
        const bool is_found = has(found[i], t);
        if (is_in_box(t, boxes[i], -1e-12 * extent)) {
          ASSERT_TRUE(is_found) << "box " << i;
          ++certain;
        } else if (is_found) {
          ASSERT_TRUE(is_in_box(t, boxes[i], 1e-12 * extent)) << "box " << i;
        }
      }
    }
    EXPECT_EQ(found[boxes.size() - 1].size(), triangles.size());
  }
  EXPECT_GT(certain, 3000U);
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

/// As the box sees it.
PlacedTriangle seen_from(const QueryOrientedBox& box, PlacedTriangle triangle) {
  for (Vec3d& x : triangle.x) {
    const Vec3d offset = x - box.centre;
    x = {dot(box.axes[0], offset), dot(box.axes[1], offset), dot(box.axes[2], offset)};
  }
  return triangle;
}

TEST(Overlaps, of_turned_boxes_are_triangles_that_are_partly_inside) {
  std::size_t certain = 0;
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    Random random(5);
    std::vector<QueryOrientedBox> boxes;
    for (int i = 0; i < 200; ++i) {
      const double size = std::exp2(random.uniform(-6, 0)) * extent;
      const std::array<Vec3d, 3> axes = random_axes(random);
      const double thickness = i % 10 == 0 ? 0.0 : random.unit();
      boxes.push_back({random.in_box(1.2 * extent),
                       {size * random.unit(), size * thickness, size * random.unit()},
                       {axes[0], axes[1], axes[2]}});
    }
    boxes.push_back({{0, 0, 0}, {kInfinity, kInfinity, kInfinity}});
    const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(boxes);
    ASSERT_EQ(found.size(), boxes.size());
    for (std::size_t i = 0; i + 1 < boxes.size(); ++i) {
      expect_in_order(found[i]);
      const QueryBox around = {-1.0 * boxes[i].half, boxes[i].half};
      for (const PlacedTriangle& t : triangles) {
        const PlacedTriangle seen = seen_from(boxes[i], t);
        const bool is_found = has(found[i], t);
        if (is_in_box(seen, around, -1e-11 * extent)) {
          ASSERT_TRUE(is_found) << "box " << i;
          ++certain;
        } else if (is_found) {
          ASSERT_TRUE(is_in_box(seen, around, 1e-11 * extent)) << "box " << i;
        }
      }
    }
    EXPECT_EQ(found[boxes.size() - 1].size(), triangles.size());
  }
  EXPECT_GT(certain, 3000U);
}

TEST(Overlaps, of_no_turned_box_are_none) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<QueryOrientedBox> boxes = {{{0, 0, 0}, {1, 1, 0}},
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
  const std::vector<QuerySphere> spheres = {
      {{0, 0, 0}, 1}, {{kNaN, 0, 0}, 1}, {{0, 0, 0}, kNaN}, {{0, 0, 0}, -1}, {{1e38, 0, 0}, 1e39}};
  const AnswerLists<TriangleOverlap> in_spheres = probed.probe.overlaps(spheres);
  EXPECT_FALSE(in_spheres[0].empty());
  for (std::size_t i = 1; i < spheres.size(); ++i) EXPECT_TRUE(in_spheres[i].empty()) << "sphere " << i;
  const std::vector<QueryBox> boxes = {
      {{-1, -1, 0}, {1, 1, 0}}, {{-1, kNaN, 0}, {1, 1, 0}}, {{-1, -1, 0}, {1, 1, kNaN}}, {{1, -1, 0}, {-1, 1, 0}}};
  const AnswerLists<TriangleOverlap> in_boxes = probed.probe.overlaps(boxes);
  EXPECT_FALSE(in_boxes[0].empty());
  for (std::size_t i = 1; i < boxes.size(); ++i) EXPECT_TRUE(in_boxes[i].empty()) << "box " << i;
}

}  // namespace
}  // namespace softcd::test
