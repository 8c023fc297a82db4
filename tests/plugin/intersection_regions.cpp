#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "probing.hpp"

// Compares regions with winding numbers and triangle-triangle segments in whole numbers, which share no code with
// the product.
namespace softcd::test {
namespace {

using Integer = boost::multiprecision::int128_t;

/// A point in units of 2^-17, in which all meshes of these comparisons have whole coordinates below 2^20.
struct IntegerVec3 {
  Integer x, y, z;
};

IntegerVec3 in_units(Vec3d p) {
  const auto whole = [](double value) { return Integer(static_cast<std::int64_t>(std::round(0x1p17 * value))); };
  return {whole(p.x), whole(p.y), whole(p.z)};
}
IntegerVec3 operator-(const IntegerVec3& a, const IntegerVec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
IntegerVec3 cross(const IntegerVec3& a, const IntegerVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Integer dot(const IntegerVec3& a, const IntegerVec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
bool is_zero(const IntegerVec3& a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}
int volume_sign(const IntegerVec3& a, const IntegerVec3& b, const IntegerVec3& c, const IntegerVec3& d) {
  return dot(a - d, cross(b - d, c - d)).sign();
}

constexpr int kOnSurface = 1000;

/// Returns how often a closed mesh winds around a point, or kOnSurface. Uses rays in directions of its own until one
/// meets no edge or vertex.
int winding_around(const Mesh& mesh, Vec3d at) {
  const IntegerVec3 p = in_units(at);
  Random random(77);
  while (true) {
    const Vec3d direction = random.direction();
    const auto far = [](const Integer& from, double along) {
      return Integer(from + (Integer(static_cast<std::int64_t>(1000 * along)) << 14));
    };
    const IntegerVec3 q = {far(p.x, direction.x), far(p.y, direction.y), far(p.z, direction.z)};
    int winding = 0;
    bool is_usable = true;
    for (const Triangle& t : mesh.triangles) {
      const IntegerVec3 a = in_units(mesh.positions[t.v[0]]);
      const IntegerVec3 b = in_units(mesh.positions[t.v[1]]);
      const IntegerVec3 c = in_units(mesh.positions[t.v[2]]);
      if (is_zero(cross(b - a, c - a))) {
        // Without area it only counts where the point lies on it.
        const auto lies_between = [&](const IntegerVec3& u, const IntegerVec3& v) {
          return is_zero(cross(p - u, v - u)) && dot(p - u, p - v).sign() <= 0;
        };
        if (lies_between(a, b) || lies_between(b, c) || lies_between(c, a)) return kOnSurface;
        continue;
      }
      const int from = volume_sign(a, b, c, p);
      const int to = volume_sign(a, b, c, q);
      const int first = volume_sign(p, q, a, b);
      const int second = volume_sign(p, q, b, c);
      const int third = volume_sign(p, q, c, a);
      if (first * second < 0 || second * third < 0 || first * third < 0 || from * to > 0) continue;
      if (from == 0 && to != 0) return kOnSurface;
      is_usable &= from != 0 && to != 0 && first != 0 && second != 0 && third != 0;
      winding += from;
    }
    if (is_usable) return winding;
  }
}

std::set<std::uint32_t> inside_vertices(const IntersectionRegions& found, BodyId body, BodyId other) {
  std::set<std::uint32_t> vertices;
  for (const IntersectionRegion& region : found.regions) {
    if (region.body != body || region.other != other || !region.is_inside) continue;
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      EXPECT_TRUE(vertices.insert(found.vertices[region.first_vertex + i].vertex).second) << "regions are disjoint";
    }
  }
  return vertices;
}

/// Expects that exactly the vertices of body a around which the closed body b winds are inside it. Vertices on its
/// surface may be either.
void expect_inside(const ProbedBodies& probed, const IntersectionRegions& found, std::size_t a, std::size_t b) {
  const Mesh other = {probed.bodies[b].triangles, probed.bodies[b].x_t1};
  const std::set<std::uint32_t> inside = inside_vertices(found, probed.ids[a], probed.ids[b]);
  for (std::uint32_t v = 0; v < probed.bodies[a].x_t1.size(); ++v) {
    const int winding = winding_around(other, probed.bodies[a].x_t1[v]);
    if (winding == kOnSurface) continue;
    ASSERT_EQ(inside.count(v) > 0, winding != 0) << "body " << a << ", vertex " << v;
  }
}

/// Expects it of all pairs of bodies, which are closed.
void expect_inside(const ProbedBodies& probed, const IntersectionRegions& found) {
  for (std::size_t a = 0; a < probed.bodies.size(); ++a) {
    for (std::size_t b = 0; b < probed.bodies.size(); ++b) {
      if (a != b) expect_inside(probed, found, a, b);
    }
  }
}

/// Returns the length of the segment that two triangles have in common; they have to be in general position. Which edge
/// passes through which triangle is decided exactly.
double common_length(const Vec3d (&a)[3], const Vec3d (&b)[3]) {
  std::vector<Vec3d> ends;
  const auto add_passages = [&](const Vec3d(&edges)[3], const Vec3d(&t)[3]) {
    const IntegerVec3 corners[3] = {in_units(t[0]), in_units(t[1]), in_units(t[2])};
    for (int i = 0; i < 3; ++i) {
      const IntegerVec3 p = in_units(edges[i]);
      const IntegerVec3 q = in_units(edges[(i + 1) % 3]);
      if (volume_sign(corners[0], corners[1], corners[2], p) * volume_sign(corners[0], corners[1], corners[2], q) >=
          0) {
        continue;
      }
      const int first = volume_sign(p, q, corners[0], corners[1]);
      if (first == 0 || first != volume_sign(p, q, corners[1], corners[2])) continue;
      if (first != volume_sign(p, q, corners[2], corners[0])) continue;
      const Vec3d normal = softcd::cross(t[1] - t[0], t[2] - t[0]);
      const double from = softcd::dot(normal, edges[i] - t[0]);
      const double to = softcd::dot(normal, edges[(i + 1) % 3] - t[0]);
      ends.push_back(lerp(edges[i], edges[(i + 1) % 3], from / (from - to)));
    }
  };
  add_passages(a, b);
  add_passages(b, a);
  return ends.size() == 2 ? std::sqrt(squared_norm(ends[1] - ends[0])) : 0;
}

double common_length(const Mesh& a, const Mesh& b) {
  double length = 0;
  for (const Triangle& s : a.triangles) {
    for (const Triangle& t : b.triangles) {
      const Vec3d of_a[3] = {a.positions[s.v[0]], a.positions[s.v[1]], a.positions[s.v[2]]};
      const Vec3d of_b[3] = {b.positions[t.v[0]], b.positions[t.v[1]], b.positions[t.v[2]]};
      length += common_length(of_a, of_b);
    }
  }
  return length;
}

double total_length(const IntersectionRegions& found) {
  double length = 0;
  for (const IntersectionCurve& curve : found.curves) length += curve.length;
  return length;
}

/// Returns a closed surface with vertices anywhere on a grid; it intersects itself.
Mesh wild_ball(Random& random, int level, double half_extent, int bits) {
  Mesh mesh = outward_ball(level, 1.0);
  for (Vec3d& x : mesh.positions) x = random.in_box(half_extent);
  snap_to_grid(mesh.positions, bits);
  return mesh;
}

/// Returns a closed surface whose rough vertices are near those of a ball.
Mesh rough_ball(Random& random, int level, double radius, Vec3d centre) {
  Mesh mesh = outward_ball(level, radius);
  for (Vec3d& x : mesh.positions) x = random.uniform(0.6, 1.4) * x + centre;
  snap_to_grid(mesh.positions, 15);
  return mesh;
}

Mesh box(Vec3d lo, Vec3d hi) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({(i & 1) != 0 ? hi.x : lo.x, (i & 2) != 0 ? hi.y : lo.y, (i & 4) != 0 ? hi.z : lo.z});
  }
  mesh.triangles = {{{0, 2, 1}}, {{1, 2, 3}}, {{4, 5, 6}}, {{5, 7, 6}}, {{0, 1, 4}}, {{1, 5, 4}},
                    {{2, 6, 3}}, {{3, 6, 7}}, {{0, 4, 2}}, {{2, 4, 6}}, {{1, 3, 5}}, {{3, 7, 5}}};
  return mesh;
}

const IntersectionRegion* region_of(const IntersectionRegions& found, BodyId body, BodyId other) {
  for (const IntersectionRegion& region : found.regions) {
    if (region.body == body && region.other == other) return &region;
  }
  return nullptr;
}

/// Expects what holds for all regions, whatever the positions.
void expect_sound(const ProbedBodies& probed, const IntersectionRegions& found) {
  for (const IntersectionCurve& curve : found.curves) {
    ASSERT_GE(curve.point_count, 2U);
    ASSERT_LE(curve.first_point + curve.point_count, found.points.size());
    ASSERT_TRUE(std::isfinite(curve.length));
  }
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const IntersectionRegion& region : found.regions) {
    ASSERT_EQ(region.first_vertex, vertices);
    ASSERT_EQ(region.first_triangle, triangles);
    vertices += region.vertex_count;
    triangles += region.triangle_count;
    ASSERT_GT(region.triangle_count, 0U);
    ASSERT_TRUE(std::isfinite(region.area));
    ASSERT_TRUE(!region.is_inside || region.body != region.other);
    const std::size_t count = probed.bodies[region.body.value].x_t1.size();
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region.first_vertex + i];
      ASSERT_LT(vertex.vertex, count);
      ASSERT_TRUE(i == 0 || found.vertices[region.first_vertex + i - 1].vertex < vertex.vertex);
      ASSERT_TRUE(std::isfinite(vertex.distance));
      ASSERT_GE(vertex.distance, 0);
      const double size = std::sqrt(squared_norm(vertex.direction));
      ASSERT_TRUE(size == 0 || std::abs(size - 1) < 1e-9);
    }
  }
  ASSERT_EQ(vertices, found.vertices.size());
  ASSERT_EQ(triangles, found.triangles.size());
}

TEST(IntersectionRegions, of_rough_balls_have_the_exact_inside) {
  Random random(11);
  int crossing = 0;
  for (int i = 0; i < 150; ++i) {
    SCOPED_TRACE(i);
    const Mesh a = rough_ball(random, i % 15 == 0 ? 1 : 0, 1.0, {0, 0, 0});
    const Mesh b = rough_ball(random, i % 15 == 0 ? 1 : 0, random.uniform(0.3, 1.2), random.in_box(0.8));
    ProbedBodies probed({still(a, {}), still(b, {})});
    const IntersectionRegions found = probed.probe.intersection_regions({probed.ids[0], probed.ids[1]});
    expect_sound(probed, found);
    expect_inside(probed, found);
    for (const IntersectionCurve& curve : found.curves) ASSERT_TRUE(curve.is_closed && !curve.is_perturbed);
    for (const IntersectionRegion& region : found.regions) ASSERT_EQ(region.kind, RegionKind::closed);
    const double length = common_length(a, b);
    ASSERT_NEAR(total_length(found), length, 1e-9 * (1 + length));
    crossing += found.curves.empty() ? 0 : 1;
  }
  EXPECT_GT(crossing, 100);
}

TEST(IntersectionRegions, of_wild_surfaces_have_the_exact_inside) {
  Random random(12);
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    const Mesh a = wild_ball(random, 0, 1.0, 15);
    const Mesh b = wild_ball(random, 0, 1.0, 15);
    ProbedBodies probed({still(a, {}), still(b, {})});
    const IntersectionRegions found = probed.probe.intersection_regions();
    expect_sound(probed, found);
    expect_inside(probed, found);
    const IntersectionRegions between = probed.probe.intersection_regions({probed.ids[0], probed.ids[1]});
    const double length = common_length(a, b);
    ASSERT_NEAR(total_length(between), length, 1e-9 * (1 + length));
  }
}

/// Vertices on faces, equal vertices, coplanar faces and faces without area.
TEST(IntersectionRegions, of_surfaces_on_a_coarse_grid_have_no_wrong_side) {
  Random random(13);
  int perturbed = 0;
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    const Mesh a = i % 2 == 0 ? wild_ball(random, 0, 2.0, 0) : box({0, 0, 0}, {2, 2, 2});
    const Mesh b = wild_ball(random, 0, 2.0, 0);
    ProbedBodies probed({still(a, {}), still(b, {})});
    const IntersectionRegions found = probed.probe.intersection_regions();
    expect_sound(probed, found);
    expect_inside(probed, found);
    for (const IntersectionRegion& region : found.regions) perturbed += region.is_perturbed ? 1 : 0;
  }
  EXPECT_GT(perturbed, 100);
}

/// Borders on faces and edges, shared vertices, coplanar faces; in every third pair all triangles are needles.
TEST(IntersectionRegions, of_open_sheets_on_a_coarse_grid_have_no_wrong_side) {
  Random random(15);
  int open = 0;
  int perturbed = 0;
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    Mesh sheet = grid_cloth(4, 3, 1.0);
    for (Vec3d& x : sheet.positions) x = random.in_box(2.0);
    snap_to_grid(sheet.positions, 0);
    Mesh closed = i % 2 == 0 ? wild_ball(random, 0, 2.0, 0) : box({0, 0, 0}, {2, 2, 2});
    for (Mesh* mesh : {&sheet, &closed}) {
      for (Vec3d& x : mesh->positions) x.x *= i % 3 == 0 ? 0x1p-16 : 1.0;
    }
    ProbedBodies probed({still(sheet, {}), still(closed, {})});
    const IntersectionRegions found = probed.probe.intersection_regions();
    expect_sound(probed, found);
    expect_inside(probed, found, 0, 1);
    for (const IntersectionCurve& curve : found.curves) open += curve.is_closed ? 0 : 1;
    for (const IntersectionRegion& region : found.regions) perturbed += region.is_perturbed ? 1 : 0;
  }
  EXPECT_GT(open, 100);
  EXPECT_GT(perturbed, 100);
}

TEST(IntersectionRegions, of_odd_scenes_are_sound) {
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    ProbedBodies probed(std::move(named.bodies));
    expect_sound(probed, probed.probe.intersection_regions());
  }
}

TEST(IntersectionRegions, of_overlapping_balls_are_two_caps) {
  const Mesh ball = outward_ball(3, 1.0);
  ProbedBodies probed({still(ball, {}), still(moved(ball, {1.5, 0.0078125, 0.015625}), {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  ASSERT_EQ(found.regions.size(), 2U);
  ASSERT_EQ(found.curves.size(), 1U);
  EXPECT_TRUE(found.curves[0].is_closed);
  // The circle in which balls of radius 1 meet, 1.5 apart.
  EXPECT_NEAR(found.curves[0].length, 2 * 3.14159265 * std::sqrt(1 - 0.75 * 0.75), 0.05);
  for (const IntersectionRegion& region : found.regions) {
    EXPECT_EQ(region.kind, RegionKind::closed);
    EXPECT_TRUE(region.is_inside);
    EXPECT_NEAR(region.area, 2 * 3.14159265 * 0.25, 0.15);
    double deepest = 0;
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region.first_vertex + i];
      deepest = std::max(deepest, vertex.distance);
      EXPECT_GT((region.body == probed.ids[0] ? -1 : 1) * vertex.direction.x, 0);
    }
    EXPECT_NEAR(deepest, 0.5, 0.05);
  }
}

TEST(IntersectionRegions, of_a_box_in_a_box_are_its_whole_surface) {
  ProbedBodies probed({still(box({0, 0, 0}, {8, 8, 8}), {}), still(box({2, 3, 3}, {4, 5, 5}), {}),
                       still(moved(grid_cloth(4, 4, 0.25), {6, 6, 6}), {}),
                       still(moved(grid_cloth(4, 4, 0.25), {9, 9, 9}), {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  ASSERT_EQ(found.regions.size(), 2U);
  EXPECT_TRUE(found.curves.empty());
  EXPECT_EQ(found.regions[0].body, probed.ids[1]);
  EXPECT_EQ(found.regions[0].other, probed.ids[0]);
  EXPECT_EQ(found.regions[0].vertex_count, 8U);
  EXPECT_EQ(found.regions[0].triangle_count, 12U);
  EXPECT_DOUBLE_EQ(found.regions[0].area, 24);
  EXPECT_DOUBLE_EQ(found.vertices[0].distance, 2);
  EXPECT_DOUBLE_EQ(found.vertices[0].direction.x, -1);
  EXPECT_EQ(found.regions[1].body, probed.ids[2]);
  EXPECT_EQ(found.regions[1].vertex_count, 16U);
  EXPECT_TRUE(probed.probe.intersection_regions({probed.ids[0], probed.ids[3]}).empty());
  EXPECT_EQ(probed.probe.intersection_regions({probed.ids[2], probed.ids[0]}).regions.size(), 1U);
}

/// Returns a cloth of 1 x `height` in the plane y = 0, from z = -below on.
Mesh hanging_cloth(double width, double height, double below) {
  const auto columns = static_cast<std::uint32_t>(width / 0.25) + 1;
  const auto rows = static_cast<std::uint32_t>(height / 0.25) + 1;
  Mesh mesh = grid_cloth(columns, rows, 0.25);
  const Vec3d lowest = mesh.positions.front();
  for (Vec3d& x : mesh.positions) {
    x = {x.x - lowest.x + 0.046875, 0.0234375 + 0.015625 * (x.x - lowest.x), x.y - lowest.y - below};
  }
  return mesh;
}

Mesh lying_cloth(double size) {
  Mesh mesh =
      grid_cloth(static_cast<std::uint32_t>(size / 0.25) + 1, static_cast<std::uint32_t>(size / 0.25) + 1, 0.25);
  const Vec3d lowest = mesh.positions.front();
  for (Vec3d& x : mesh.positions) x = {x.x - lowest.x - size / 2, x.y - lowest.y - size / 2, 0};
  return mesh;
}

TEST(IntersectionRegions, of_crossed_cloths_end_at_the_narrow_ones_border) {
  ProbedBodies probed({still(hanging_cloth(1, 3, 1.109375), {}), still(lying_cloth(4), {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  ASSERT_EQ(found.curves.size(), 1U);
  EXPECT_FALSE(found.curves[0].is_closed);
  EXPECT_NEAR(found.curves[0].length, 1, 0.01);
  ASSERT_EQ(found.regions.size(), 2U);
  const IntersectionRegion& below = found.regions[0];
  EXPECT_EQ(below.kind, RegionKind::loop_with_border);
  EXPECT_EQ(below.vertex_count, 5U * 5U);
  for (std::uint32_t i = 0; i < below.vertex_count; ++i) {
    const RegionVertex& vertex = found.vertices[below.first_vertex + i];
    EXPECT_NEAR(vertex.direction.z, 1, 1e-9);
    EXPECT_NEAR(vertex.distance, -probed.bodies[0].x_t1[vertex.vertex].z, 1e-9);
  }
  EXPECT_EQ(found.regions[1].kind, RegionKind::open);
  EXPECT_EQ(found.regions[1].area, 0);
}

TEST(IntersectionRegions, that_are_open_on_both_sides_shorten_their_curve) {
  // The hanging cloth reaches over the border of the lying one.
  Scene bodies = {still(hanging_cloth(2, 1, 0.40625), {}), still(moved(lying_cloth(2), {0, 0, 0.0078125}), {})};
  for (SceneBody& body : bodies) {
    for (Vec3d& x : body.x_t1) x = {x.x + 0.125 * x.z, x.y + 0.25 * x.z, x.z + 0.125 * x.x + 0.0625 * x.y};
    body.x_t0 = body.x_t1;
  }
  ProbedBodies probed(std::move(bodies));
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  ASSERT_EQ(found.regions.size(), 2U);
  const double length = total_length(found);
  constexpr double kStep = 1.0 / 64;
  Scene moving = probed.bodies;
  for (const IntersectionRegion& region : found.regions) {
    EXPECT_EQ(region.kind, RegionKind::open);
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region.first_vertex + i];
      Vec3d& x = moving[region.body.value].x_t1[vertex.vertex];
      x = x + (kStep * vertex.distance) * vertex.direction;
    }
  }
  for (std::size_t body = 0; body < 2; ++body) probed.scene.set_positions(probed.ids[body], moving[body].x_t1);
  const double shorter = total_length(probed.probe.intersection_regions());
  EXPECT_NEAR(shorter, (1 - kStep) * length, 0.1 * kStep * length);
}

TEST(IntersectionRegions, of_a_cloth_half_way_through_a_ball_are_its_inner_part) {
  const Mesh ball = outward_ball(3, 1.0);
  const Mesh cloth = moved(hanging_cloth(0.5, 3, 0), {-0.25, 0, 0});
  ProbedBodies probed({still(cloth, {}), still(ball, {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  const IntersectionRegion* const inner = region_of(found, probed.ids[0], probed.ids[1]);
  ASSERT_NE(inner, nullptr);
  EXPECT_TRUE(inner->is_inside);
  EXPECT_EQ(inner->kind, RegionKind::loop_with_border);
  std::set<std::uint32_t> expected;
  for (std::uint32_t v = 0; v < cloth.positions.size(); ++v) {
    if (winding_around(ball, cloth.positions[v]) != 0) expected.insert(v);
  }
  EXPECT_EQ(inside_vertices(found, probed.ids[0], probed.ids[1]), expected);
  EXPECT_EQ(region_of(found, probed.ids[1], probed.ids[0])->kind, RegionKind::open);
}

/// Returns a cloth with two layers, z = 0 and z = 1, joined at one side. The upper one has a dent through the lower
/// one.
Mesh dented_fold() {
  Mesh mesh = grid_cloth(41, 17, 0.125);
  const Vec3d lowest = mesh.positions.front();
  for (Vec3d& x : mesh.positions) {
    const double along = x.x - lowest.x;
    const double across = x.y - lowest.y - 1.03125;
    const double u = along < 2 ? along : (along < 3 ? 2 : 5 - along);
    const double z = along < 2 ? 0 : (along < 3 ? along - 2 : 1);
    const double from_dent = std::sqrt((u - 1.015625) * (u - 1.015625) + across * across);
    x = {u, across, along > 3 ? z - std::max(0.0, 1.5 - 2 * from_dent) : z};
  }
  snap_to_grid(mesh.positions, 15);
  return mesh;
}

TEST(IntersectionRegions, of_a_cloth_with_itself_lead_to_each_other) {
  ProbedBodies probed({still(dented_fold(), {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  ASSERT_EQ(found.curves.size(), 1U);
  EXPECT_TRUE(found.curves[0].is_closed);
  ASSERT_EQ(found.regions.size(), 2U);
  for (const IntersectionRegion& region : found.regions) {
    EXPECT_EQ(region.kind, RegionKind::closed);
    EXPECT_FALSE(region.is_inside);
    ASSERT_GT(region.vertex_count, 0U);
    const bool is_dent = probed.bodies[0].x_t1[found.vertices[region.first_vertex].vertex].z < 0;
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region.first_vertex + i];
      EXPECT_EQ(probed.bodies[0].x_t1[vertex.vertex].z < 0, is_dent);
      EXPECT_GT(is_dent ? vertex.direction.z : -vertex.direction.z, 0.2);
      EXPECT_LT(vertex.distance, 0.55);
    }
  }
}

/// A sheet through the middle of a triangle and a needle through it reach no vertex.
/// Rounding to float32 would move the corner by up to 2e-6.
TEST(IntersectionRegions, of_doubles_lead_out_of_the_least_depth) {
  const Vec3d place = {10, 20, 30};
  const Vec3d normal = 1.0 / 3.0 * Vec3d{1, 2, 2};
  const Vec3d along = 1.0 / 3.0 * Vec3d{2, 1, -2};
  const Vec3d across = cross(normal, along);
  const Mesh plate = {{{{0, 1, 2}}}, {place + along, place - along + across, place - along - across}};
  Random random(4);
  for (int i = 0; i < 40; ++i) {
    const double depth = 1e-9 * (i + 1);
    const Vec3d corner =
        place + random.uniform(-0.1, 0.1) * along + random.uniform(-0.1, 0.1) * across - depth * normal;
    const Vec3d top = corner + normal;
    const Mesh tip = {{{{0, 2, 1}}, {{0, 3, 2}}, {{0, 1, 3}}, {{1, 2, 3}}},
                      {corner, top + 0.5 * along, top + 0.5 * across, top - 0.5 * along - 0.5 * across}};
    for (const double height : {0.0, 2 * depth}) {
      SCOPED_TRACE(testing::Message() << "depth " << depth << " at height " << height);
      ProbedBodies probed({still(tip, {}), still(plate, {})});
      const Positions3 x = moved(tip, height * normal).positions;
      probed.scene.set_positions(probed.ids[0], x);
      const IntersectionRegions found = probed.probe.intersection_regions();
      if (height > 0) {
        EXPECT_TRUE(found.curves.empty());
        EXPECT_EQ(found.touching_pairs, 0U);
        continue;
      }
      ASSERT_EQ(found.curves.size(), 1U);
      EXPECT_TRUE(found.curves[0].is_closed);
      ASSERT_EQ(found.regions.size(), 2U);
      ASSERT_EQ(found.regions[0].vertex_count, 1U);
      const RegionVertex& vertex = found.vertices[found.regions[0].first_vertex];
      EXPECT_EQ(vertex.vertex, 0U);
      EXPECT_NEAR(vertex.distance, depth, 1e-13);
      EXPECT_GT(dot(vertex.direction, normal), 0.999);
    }
  }
}

TEST(IntersectionRegions, without_a_vertex_have_triangles) {
  const Mesh needle = box({0.625, 0.5, -1}, {0.6875, 0.5625, 1});
  const Mesh sheet = {{{{0, 1, 2}}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  ProbedBodies probed({still(needle, {}), still(sheet, {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  const IntersectionRegion* const hole = region_of(found, probed.ids[1], probed.ids[0]);
  ASSERT_NE(hole, nullptr);
  EXPECT_EQ(hole->kind, RegionKind::closed);
  EXPECT_TRUE(hole->is_inside);
  EXPECT_EQ(hole->vertex_count, 0U);
  EXPECT_EQ(hole->triangle_count, 1U);
  EXPECT_DOUBLE_EQ(hole->area, 0.0625 * 0.0625);
  const IntersectionRegion* const half = region_of(found, probed.ids[0], probed.ids[1]);
  ASSERT_NE(half, nullptr);
  EXPECT_EQ(half->kind, RegionKind::closed);
  EXPECT_EQ(half->vertex_count, 4U);
}

TEST(IntersectionRegions, of_boxes_that_touch_are_marked) {
  ProbedBodies probed({still(box({0, 0, 0}, {1, 1, 1}), {}), still(box({0.25, 0.25, 1}, {0.5, 0.5, 2}), {}),
                       still(box({4, 0, 0}, {5, 1, 1}), {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  EXPECT_TRUE(!found.curves.empty() || found.touching_pairs > 0);
  for (const IntersectionRegion& region : found.regions) EXPECT_TRUE(region.is_perturbed);
  for (const RegionVertex& vertex : found.vertices) EXPECT_EQ(vertex.distance, 0);
}

TEST(IntersectionRegions, at_an_edge_of_three_triangles_are_degenerate) {
  const Mesh book = {{{{0, 1, 2}}, {{0, 1, 3}}, {{0, 1, 4}}},
                     {{0, 0, -1}, {0, 0, 1}, {2, 0.5, 0}, {-2, 0.5, 0}, {0.25, 2, 0}}};
  ProbedBodies probed({still(book, {}), still(moved(lying_cloth(8), {0.0625, 0.03125, 0.125}), {})});
  const IntersectionRegions found = probed.probe.intersection_regions();
  expect_sound(probed, found);
  EXPECT_EQ(found.curves.size(), 3U);
  ASSERT_FALSE(found.empty());
  for (const IntersectionRegion& region : found.regions) EXPECT_EQ(region.kind, RegionKind::degenerate);
}

TEST(IntersectionRegions, of_an_unchanged_scene_are_the_same) {
  Random random(14);
  ProbedBodies probed({still(wild_ball(random, 1, 1.0, 15), {}), still(wild_ball(random, 1, 1.0, 15), {}),
                       still(crumpled_cloth(16, 14, 0.25, 0.05, 5), {})});
  const auto bytes = [&](std::uint32_t threads) {
    SceneOptions options = probed.scene.options();
    options.max_threads = threads;
    probed.scene.set_options(options);
    const IntersectionRegions found = probed.probe.intersection_regions();
    std::vector<double> values;
    for (const IntersectionRegion& region : found.regions)
      values.insert(values.end(), {region.area, region.curve_length});
    for (const RegionVertex& v : found.vertices) values.insert(values.end(), {v.direction.x, v.distance});
    for (const CurvePoint& point : found.points) values.push_back(point.position.x);
    for (const std::uint32_t t : found.triangles) values.push_back(t);
    return values;
  };
  const std::vector<double> one = bytes(1);
  EXPECT_GT(one.size(), 1000U);
  EXPECT_EQ(one, bytes(4));
}

TEST(IntersectionRegions, are_none_where_nothing_meets) {
  softcd::Scene scene(scene_options());
  Probe probe(scene);
  EXPECT_TRUE(probe.intersection_regions().empty());
  const Mesh ball = outward_ball(1, 1.0);
  ProbedBodies probed({still(ball, {}), still(moved(ball, {4, 0, 0}), {})});
  EXPECT_TRUE(probed.probe.intersection_regions().empty());
  EXPECT_THROW(probed.probe.intersection_regions({BodyId{7}, {}}), InvalidInput);
}

}  // namespace
}  // namespace softcd::test
