#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include "probing.hpp"
#include "softcd/math/ray_triangle.hpp"

// Compares rays through a scene with every single triangle.
namespace softcd::test {
namespace {

using testing::HasSubstr;

using HitKey = std::tuple<double, std::uint32_t, std::uint32_t>;

HitKey key_of(const RayHit& hit) {
  return {hit.t, hit.body.value, hit.triangle};
}

std::vector<HitKey> keys_of(Span<const RayHit> hits) {
  std::vector<HitKey> keys;
  for (const RayHit& hit : hits) keys.push_back(key_of(hit));
  return keys;
}

/// Returns the crossings by softcd's own test: none of them may be missed.
std::vector<HitKey> all_crossings(const std::vector<PlacedTriangle>& triangles, const Ray& ray) {
  std::vector<HitKey> keys;
  ShearedRay sheared;
  if (!shear(ray, {0, 0, 0}, sheared)) return keys;
  for (const PlacedTriangle& triangle : triangles) {
    const Vec3f x[3] = {vec3_cast<float>(triangle.x[0]), vec3_cast<float>(triangle.x[1]),
                        vec3_cast<float>(triangle.x[2])};
    RayCrossing crossing;
    if (!find_crossing(sheared, x, crossing) || crossing.t < ray.t_min || crossing.t > ray.t_max) continue;
    keys.emplace_back(crossing.t, triangle.body.value, triangle.index);
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

/// Returns rays through and past a scene, along axes, through vertices, and of many lengths.
std::vector<Ray> many_rays(const std::vector<PlacedTriangle>& triangles, double extent, std::uint64_t seed) {
  Random random(seed);
  std::vector<Ray> rays;
  const auto vertex = [&] {
    return triangles[random.below(static_cast<std::uint32_t>(triangles.size()))].x[random.below(3)];
  };
  for (int i = 0; i < 60; ++i) {
    const Vec3d from = random.in_box(1.5 * extent);
    const double length = std::exp2(random.uniform(-20, 20));
    rays.push_back({from, length * random.direction()});
    rays.push_back({from, vertex() - from});
    rays.push_back(segment(from, vertex()));
    rays.push_back(segment(vertex(), vertex()));
    rays.push_back({from, random.direction(), -kInfinity, kInfinity});
    rays.push_back({1e5 * from, -length * from, 0, kInfinity});
    Vec3d along{0, 0, 0};
    (i % 3 == 0 ? along.x : (i % 3 == 1 ? along.y : along.z)) = i % 2 == 0 ? 1.0 : -1.0;
    rays.push_back({vertex() - (2 * extent) * along, along});
    rays.push_back({from, along, random.uniform(-3, 0) * extent, random.uniform(0, 3) * extent});
  }
  return rays;
}

TEST(Rays, meet_what_they_meet_of_all_triangles) {
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    const std::vector<Ray> rays = many_rays(triangles, extent, 7);
    const AnswerLists<RayHit> all = probed.probe.all_hits(rays);
    ASSERT_EQ(all.size(), rays.size());
    std::vector<std::vector<HitKey>> expected;
    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      expected.push_back(all_crossings(triangles, rays[i]));
      ASSERT_EQ(keys_of(all[i]), expected[i]) << "ray " << i;
      hits += expected[i].size();
    }
    EXPECT_EQ(all.all().size(), hits);
    EXPECT_TRUE(hits > 50U || named.name == "one point") << hits;
    const Span<const RayHit> first = probed.probe.first_hits(rays);
    ASSERT_EQ(first.size(), rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(first[i].has_hit(), !expected[i].empty()) << "ray " << i;
      if (!expected[i].empty()) {
        ASSERT_EQ(key_of(first[i]), expected[i].front()) << "ray " << i;
      }
    }
  }
}

/// The usual test in long double, with the depth inside the triangle, in weights.
struct PlainCrossing {
  long double t, depth;
};
PlainCrossing plain_crossing(const PlacedTriangle& triangle, const Ray& ray) {
  const LongVec3 a = vec3_cast<long double>(triangle.x[0]);
  const LongVec3 b = vec3_cast<long double>(triangle.x[1]) - a;
  const LongVec3 c = vec3_cast<long double>(triangle.x[2]) - a;
  const LongVec3 d = vec3_cast<long double>(ray.direction);
  const LongVec3 from = vec3_cast<long double>(ray.origin) - a;
  const LongVec3 across = cross(d, c);
  const long double determinant = dot(b, across);
  const long double v = dot(from, across) / determinant;
  const long double w = dot(d, cross(from, b)) / determinant;
  return {dot(c, cross(from, b)) / determinant, std::min({v, w, 1 - v - w})};
}

TEST(Rays, meet_what_another_test_meets) {
  ProbedBodies probed({still(crumpled_cloth(12, 10, 0.25, 0.1, 3), {}), still(outward_ball(2, 1.0), {})});
  const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
  Random random(5);
  std::vector<Ray> rays;
  for (int i = 0; i < 500; ++i) {
    const Vec3d from = random.in_box(3);
    rays.push_back({from, random.in_box(1) - from});
  }
  const AnswerLists<RayHit> all = probed.probe.all_hits(rays);
  std::size_t certain = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (const PlacedTriangle& triangle : triangles) {
      const PlainCrossing crossing = plain_crossing(triangle, rays[i]);
      if (std::abs(crossing.depth) < 1e-9L || std::abs(crossing.t) < 1e-9L || std::isnan(crossing.depth)) continue;
      const bool is_met = crossing.depth > 0 && crossing.t > 0;
      const auto* const found = std::find_if(all[i].begin(), all[i].end(), [&](const RayHit& hit) {
        return hit.body == triangle.body && hit.triangle == triangle.index;
      });
      ASSERT_EQ(found != all[i].end(), is_met) << "ray " << i;
      if (!is_met) continue;
      ASSERT_NEAR(found->t, static_cast<double>(crossing.t), 1e-7 * (1 + found->t));
      ++certain;
    }
  }
  EXPECT_GT(certain, 300U);
}

TEST(Rays, tell_where_they_meet) {
  ProbedBodies probed({still(outward_ball(2, 1.0), {})});
  Random random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 200; ++i) {
    const Vec3d from = 2.0 * random.direction();
    rays.push_back({from, random.in_box(0.6) - from});
  }
  std::size_t hits = 0;
  const std::vector<RayHit> found = copy_of(probed.probe.first_hits(rays));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RayHit& hit = found[i];
    if (!hit.has_hit()) continue;
    ++hits;
    const auto& v = probed.bodies[0].triangles[hit.triangle].v;
    const Positions3& x = probed.bodies[0].x_t1;
    const Vec3d by_weights =
        double(hit.weights[0]) * x[v[0]] + double(hit.weights[1]) * x[v[1]] + double(hit.weights[2]) * x[v[2]];
    EXPECT_LT(norm(by_weights - (rays[i].origin + hit.t * rays[i].direction)), 1e-6);
    EXPECT_NEAR(hit.weights[0] + hit.weights[1] + hit.weights[2], 1, 1e-6);
    const Vec3d across = cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]);
    EXPECT_LT(norm(vec3_cast<double>(hit.normal) - (1 / norm(across)) * across), 1e-6);
    EXPECT_LT(dot(vec3_cast<double>(hit.normal), rays[i].direction), 0) << "met from outside";
    EXPECT_EQ(key_of(probed.probe.first_hit(rays[i])), key_of(hit));
  }
  EXPECT_GT(hits, 50U);
}

/// Expects hits by rays exactly at vertices, at the middles of edges and at other points of them, from inside and
/// outside. `core` is a place inside from which the point can be seen.
template <class Core>
void expect_no_holes(const Mesh& mesh, const Core& core) {
  ProbedBodies probed({still(mesh, {})});
  Random random(11);
  std::vector<Ray> rays;
  for (const PlacedTriangle& triangle : placed_triangles(probed)) {
    const auto& x = triangle.x;
    for (const Vec3d& target : {x[0], lerp(x[0], x[1], random.unit()), 0.5 * (x[1] + x[2])}) {
      const Vec3d inside = core(target);
      const Vec3d outside = target + 3.0 * (target - inside);
      rays.push_back({inside, target - inside, 1 - 1e-6, 1 + 1e-6});
      rays.push_back({outside, target - outside, 1 - 1e-6, 1 + 1e-6});
    }
  }
  const Span<const RayHit> hits = probed.probe.first_hits(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(hits[i].has_hit()) << "ray " << i;
}

TEST(Rays, do_not_slip_through_a_closed_surface) {
  expect_no_holes(outward_ball(3, 1.0), [](Vec3d /*target*/) { return Vec3d{0.01, -0.02, 0.03}; });
  expect_no_holes(scaled(outward_ball(2, 1.0), 0x1p-60), [](Vec3d /*target*/) { return Vec3d{0, 0, 0}; });
  Mesh ring = torus(1.0, 0.4, 40, 24);
  snap_to_grid(ring.positions, 17);
  expect_no_holes(ring, [](Vec3d target) {
    const double distance = std::hypot(target.x, target.y);
    return Vec3d{target.x / distance, target.y / distance, 0.01};
  });
}

// Vertices that are exact in every arithmetic: rays along axes and diagonals through vertices and edges of a cube.
TEST(Rays, pass_through_corners_and_edges_of_a_cube) {
  Mesh cube;
  for (int i = 0; i < 8; ++i) cube.positions.push_back({double(i & 1), double((i >> 1) & 1), double(i >> 2)});
  for (const auto& q : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    cube.triangles.push_back({{q[0], q[1], q[2]}});
    cube.triangles.push_back({{q[0], q[2], q[3]}});
  }
  ProbedBodies probed({still(cube, {})});
  const Vec3d centre{0.5, 0.5, 0.5};
  std::vector<Ray> rays;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) {
        if (x != 0 || y != 0 || z != 0) rays.push_back({centre, {double(x), double(y), double(z)}});
      }
    }
  }
  const Span<const RayHit> hits = probed.probe.first_hits(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(hits[i].has_hit());
    EXPECT_EQ(hits[i].t, 0.5 / max_norm(rays[i].direction));
  }
}

TEST(Rays, end_where_they_are_told) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const Vec3d above{0.3, 0.4, 2};
  const auto hits = [&](const Ray& ray) { return probed.probe.first_hit(ray).has_hit(); };
  EXPECT_TRUE(hits(segment(above, {0.3, 0.4, 0})));
  EXPECT_TRUE(hits(segment(above, {0.3, 0.4, -1})));
  EXPECT_FALSE(hits(segment(above, {0.3, 0.4, 0.0001})));
  EXPECT_TRUE(hits({above, {0, 0, -1}, 2, 2}));
  EXPECT_FALSE(hits({above, {0, 0, -1}, 2.0001, 5}));
  EXPECT_FALSE(hits({above, {0, 0, 1}}));
  EXPECT_TRUE(hits({above, {0, 0, 1}, -3, 5}));
  EXPECT_TRUE(hits({above, {0, 0, -1e-300}}));
  EXPECT_TRUE(hits({above, {0, 0, -1e300}}));
  // The ray lies in the triangle's plane.
  EXPECT_FALSE(hits({{-1, 0.4, 0}, {1, 0, 0}}));
}

TEST(Rays, that_are_none_meet_nothing) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const Vec3d from{0.3, 0.4, 2};
  const Vec3d down{0, 0, -1};
  std::vector<Ray> rays = {{from, down},
                           {from, {0, 0, 0}},
                           {{kNaN, 0, 0}, down},
                           {from, {0, kNaN, -1}},
                           {{0.3, 0.4, kInfinity}, down},
                           {from, {0, 0, -kInfinity}},
                           {from, down, kNaN, kInfinity},
                           {from, down, 0, kNaN},
                           {from, down, 3, 1},
                           {{0.3, 0.4, 1e38}, down},
                           {{0.3, 1e300, 2}, {0, -1, 0}}};
  const std::vector<RayHit> first = copy_of(probed.probe.first_hits(rays));
  EXPECT_TRUE(first[0].has_hit());
  const AnswerLists<RayHit> all = probed.probe.all_hits(rays);
  EXPECT_EQ(all[0].size(), 1U);
  for (std::size_t i = 1; i < rays.size(); ++i) {
    EXPECT_FALSE(first[i].has_hit()) << "ray " << i;
    EXPECT_TRUE(all[i].empty()) << "ray " << i;
  }
}

using Integers = std::array<std::int64_t, 3>;

Integers integers(Vec3d x) {
  return {std::int64_t(x.x), std::int64_t(x.y), std::int64_t(x.z)};
}

/// Returns whether the ray meets the triangle, borders included, for small integer coordinates. A triangle in a plane
/// with the ray is not met.
bool is_met(const Ray& ray, const Vec3d (&x)[3]) {
  const Integers d = integers(ray.direction);
  bool has_negative = false, has_positive = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Integers p = integers(x[i] - ray.origin);
    const Integers q = integers(x[(i + 1) % 3] - ray.origin);
    const std::int64_t side =
        d[0] * (p[1] * q[2] - p[2] * q[1]) + d[1] * (p[2] * q[0] - p[0] * q[2]) + d[2] * (p[0] * q[1] - p[1] * q[0]);
    has_negative |= side < 0;
    has_positive |= side > 0;
  }
  return has_negative != has_positive;
}

// One in ten lies in the plane of a triangle, of which some have no area.
TEST(Rays, of_integers_meet_what_exact_arithmetic_says) {
  Random random(7);
  const auto point = [&] {
    const auto coordinate = [&] { return double(random.below(7)) - 3; };
    return Vec3d{coordinate(), coordinate(), coordinate()};
  };
  Mesh mesh;
  for (std::uint32_t t = 0; t < 60; ++t) {
    mesh.triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
    for (int corner = 0; corner < 3; ++corner) mesh.positions.push_back(point());
  }
  ProbedBodies probed({still(mesh, {})});
  std::vector<Ray> rays;
  while (rays.size() < 1000) {
    const Ray ray = {point(), point(), -kInfinity, kInfinity};
    if (max_norm(ray.direction) > 0) rays.push_back(ray);
  }
  const AnswerLists<RayHit> hits = probed.probe.all_hits(rays);
  const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    std::vector<std::uint32_t> expected;
    for (const PlacedTriangle& triangle : triangles) {
      if (is_met(rays[i], triangle.x)) expected.push_back(triangle.index);
    }
    std::vector<std::uint32_t> met;
    for (const RayHit& hit : hits[i]) met.push_back(hit.triangle);
    std::sort(met.begin(), met.end());
    ASSERT_EQ(met, expected) << "ray " << i;
  }
}

// The ray's doubles keep their full precision.
TEST(Rays, meet_a_scene_that_is_far_away) {
  const Vec3d distant{3e6, -5e6, 1e6};
  ProbedBodies probed({still(moved(outward_ball(2, 1.0), distant), {})});
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Vec3d out = random.direction();
    const RayHit hit = probed.probe.first_hit({distant + 3.0 * out, -out});
    ASSERT_TRUE(hit.has_hit());
    EXPECT_NEAR(hit.t, 2, 0.06);
  }
  EXPECT_NEAR(probed.probe.first_hit({{0, 0, 0}, distant}).t, 1, 1e-6);
}

}  // namespace
}  // namespace softcd::test
