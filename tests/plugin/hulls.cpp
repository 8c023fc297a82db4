#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "overlapping.hpp"
#include "reference_distance.hpp"
#include "softcd/math/scalar.hpp"

// Checks triangles that convex hulls overlap in three ways: against all tetrahedra and triangles of the hull's points
// in long double, against half-spaces, and with distances known by construction.
namespace softcd::test {
namespace {

using Corners = std::array<Vec3d, 3>;

/// A hull that owns its points.
struct Hull {
  std::vector<Vec3d> points;
  double radius = 0;

  ProbeHull query() const { return {points, radius}; }
};

std::vector<ProbeHull> queries_of(const std::vector<Hull>& hulls) {
  std::vector<ProbeHull> queries;
  for (const Hull& hull : hulls) queries.push_back(hull.query());
  return queries;
}

bool are_same(const TriangleOverlap& a, const TriangleOverlap& b) {
  return a.body == b.body && a.triangle == b.triangle;
}

/// The relation of a hull and a triangle.
struct Meeting {
  long double distance = std::numeric_limits<long double>::infinity();
  bool is_certain = false;  ///< they intersect by more than rounding

  void add(long double another) { distance = std::min(distance, another); }
};

/// Records that a segment passes through a triangle: it has a point in the triangle's plane there.
void add_passing(const Vec3d& p, const Vec3d& q, const Corners& t, Meeting& meeting) {
  const LongVec3 a = vec3_cast<long double>(t[0]);
  const LongVec3 normal = cross(vec3_cast<long double>(t[1]) - a, vec3_cast<long double>(t[2]) - a);
  const long double length = std::sqrt(squared_norm(normal));
  const long double p_height = dot(normal, vec3_cast<long double>(p) - a) / length;
  const long double q_height = dot(normal, vec3_cast<long double>(q) - a) / length;
  if (!(p_height * q_height < 0)) return;
  const LongVec3 through = lerp(vec3_cast<long double>(p), vec3_cast<long double>(q), p_height / (p_height - q_height));
  const Vec3d point = vec3_cast<double>(through);
  const long double distance = distance_vertex_triangle(point, t[0], t[1], t[2]);
  const long double size = std::sqrt(squared_norm(q - p)) + std::sqrt(squared_norm(t[1] - t[0]));
  long double border = std::numeric_limits<long double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) border = std::min(border, distance_point_segment(point, t[i], t[(i + 1) % 3]));
  meeting.add(distance <= 1e-14L * size ? 0 : distance);
  meeting.is_certain |= distance <= 1e-14L * size && border > 1e-9L * size &&
                        std::min(std::abs(p_height), std::abs(q_height)) > 1e-9L * size;
}

void add_triangles(const Corners& a, const Corners& b, Meeting& meeting) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    meeting.add(distance_vertex_triangle(a[i], b[0], b[1], b[2]));
    meeting.add(distance_vertex_triangle(b[i], a[0], a[1], a[2]));
    for (std::size_t j = 0; j < 3; ++j) meeting.add(distance_edge_edge(a[i], a[next], b[j], b[(j + 1) % 3]));
    add_passing(a[i], a[next], b, meeting);
    add_passing(b[i], b[next], a, meeting);
  }
}

void add_inside(Vec3d p, const std::array<Vec3d, 4>& corners, Meeting& meeting) {
  LongVec3 x[4];
  for (std::size_t i = 0; i < 4; ++i) x[i] = vec3_cast<long double>(corners[i]) - vec3_cast<long double>(p);
  const auto volume = [](LongVec3 a, LongVec3 b, LongVec3 c) { return dot(cross(a, b), c); };
  const long double parts[4] = {volume(x[1], x[2], x[3]), -volume(x[0], x[2], x[3]), volume(x[0], x[1], x[3]),
                                -volume(x[0], x[1], x[2])};
  const long double whole = parts[0] + parts[1] + parts[2] + parts[3];
  const long double size = std::sqrt(squared_norm(x[1] - x[0])) * std::sqrt(squared_norm(x[2] - x[0])) *
                           std::sqrt(squared_norm(x[3] - x[0]));
  if (!(std::abs(whole) > 1e-6L * size)) return;
  const long double least = std::min({parts[0] / whole, parts[1] / whole, parts[2] / whole, parts[3] / whole});
  if (least >= -1e-16L) meeting.add(0);
  meeting.is_certain |= least > 1e-9L;
}

/// Compares the triangle with all tetrahedra and triangles of the hull's points, which make up the hull and its
/// surface.
Meeting meeting_of(const Hull& hull, const PlacedTriangle& triangle) {
  const Corners t = {triangle.x[0], triangle.x[1], triangle.x[2]};
  const auto& x = hull.points;
  const std::size_t n = x.size();
  Meeting meeting;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = std::min(i + 1, n - 1); j < n; ++j) {
      for (std::size_t k = std::min(j + 1, n - 1); k < n; ++k) {
        add_triangles({x[i], x[j], x[k]}, t, meeting);
        for (std::size_t l = k + 1; l < n; ++l) add_inside(t[0], {x[i], x[j], x[k], x[l]}, meeting);
      }
    }
  }
  return meeting;
}

/// Returns up to six points: anywhere, in a plane, on a line, repeated, or corners of the scene's triangles.
Hull random_hull(Random& random, double extent, const std::vector<PlacedTriangle>& triangles) {
  const auto of_scene = [&] { return triangles[random.below(std::uint32_t(triangles.size()))].x[random.below(3)]; };
  Hull hull;
  const std::uint32_t kind = random.below(5);
  const Vec3d middle = kind == 0 ? of_scene() : random.in_box(1.1 * extent);
  const double size = std::exp2(random.uniform(-6, 0)) * extent;
  const Vec3d along = size * random.direction();
  for (std::uint32_t i = 1 + random.below(6); i > 0; --i) {
    Vec3d by = random.in_box(size);
    if (kind == 1) by.z = 0;
    if (kind == 2) by = random.uniform(-1, 1) * along;
    if (kind == 3 && random.chance(0.4)) by = {0, 0, 0};
    hull.points.push_back(kind == 4 && random.chance(0.5) ? of_scene() : middle + by);
  }
  if (random.chance(0.5)) hull.radius = std::exp2(random.uniform(-8, -2)) * extent;
  return hull;
}

double gap_of_boxes(const Hull& hull, const PlacedTriangle& triangle) {
  double gap = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [t_lo, t_hi] = std::minmax({triangle.x[0][axis], triangle.x[1][axis], triangle.x[2][axis]});
    double lo = hull.points[0][axis];
    double hi = lo;
    for (const Vec3d& p : hull.points) {
      lo = std::min(lo, p[axis]);
      hi = std::max(hi, p[axis]);
    }
    gap = std::max({gap, t_lo - hi, lo - t_hi});
  }
  return gap;
}

TEST(Hulls, of_few_points_overlap_what_their_tetrahedra_do) {
  const auto make = [](Random& random, double extent, const std::vector<PlacedTriangle>& triangles) {
    std::vector<Hull> hulls;
    for (int i = 0; i < 40; ++i) hulls.push_back(random_hull(random, extent, triangles));
    return hulls;
  };
  std::size_t apart = 0;
  const auto judge = [&apart](const Hull& hull, const PlacedTriangle& t, double extent) {
    const double slack = 1e-10 * extent;
    if (gap_of_boxes(hull, t) > hull.radius + slack) return Verdict::apart;
    const Meeting meeting = meeting_of(hull, t);
    if (meeting.is_certain) return Verdict::overlapping;
    const Verdict verdict = verdict_on(static_cast<double>(meeting.distance) - hull.radius, slack);
    if (verdict == Verdict::apart) ++apart;
    return verdict;
  };
  EXPECT_GT(compare_overlaps(9, make, judge), 1500U);
  EXPECT_GT(apart, 1500U);
}

/// A triangle and a hull on two sides of a plane. Both have a point at the same place of the plane.
struct Facing {
  Mesh triangle;
  Hull hull;
};

/// Makes such a pair: `corners` of the triangle are in the plane, and `points` of the hull are `gap` from it.
Facing facing(Random& random, Vec3d centre, int corners, int points, double gap) {
  Facing made;
  Positions3& x = made.triangle.positions;
  made.triangle.triangles = {{{0, 1, 2}}};
  const double size = std::exp2(random.uniform(-6, 0));
  const Vec3d first = random.direction();
  const Vec3d second = unit_vector(cross(first, random.direction()));
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * i + random.uniform(-0.5, 0.5);
    const Vec3d corner = centre + (size * std::cos(angle)) * first + (size * std::sin(angle)) * second;
    x.push_back(vec3_cast<double>(vec3_cast<float>(corner)));
  }
  Vec3d normal = cross(x[1] - x[0], x[2] - x[0]);
  Vec3d at = x[0] + 0.3 * (x[1] - x[0]) + 0.4 * (x[2] - x[0]);
  if (corners == 2) {
    normal = cross(x[1] - x[0], random.direction());
    at = lerp(x[0], x[1], random.uniform(0.2, 0.8));
  } else if (corners == 1) {
    normal = -1.0 * (unit_vector(x[1] - x[0]) + unit_vector(x[2] - x[0]));
    at = x[0];
  }
  normal = unit_vector(normal);
  if (corners == 2 && dot(normal, x[2] - x[0]) > 0) normal = -normal;
  const Vec3d right = unit_vector(cross(normal, random.direction()));
  const Vec3d up = cross(normal, right);
  const double width = std::exp2(random.uniform(-6, 0));
  const double start = random.uniform(0, 6);
  for (int i = 0; i < points; ++i) {
    const double angle = start + 2 * 3.14159265358979323846 * i / points;
    const double reach = points == 1 ? 0.0 : random.uniform(0.5, 1) * width;
    made.hull.points.push_back(at + gap * normal + (reach * std::cos(angle)) * right + (reach * std::sin(angle)) * up);
  }
  // The rest of the hull; some points are nearly or exactly in the plane, too.
  for (std::uint32_t i = 1 + random.below(8); i > 0; --i) {
    const double height = random.chance(0.5) ? width * random.unit() : std::exp2(random.uniform(-40, 0)) * width;
    made.hull.points.push_back(at + (gap + height) * normal + (width * random.uniform(-1, 1)) * right +
                               (width * random.uniform(-1, 1)) * up);
  }
  // So that points beyond the plane are inside by as much.
  for (int i = 0; i < 3; ++i) {
    made.hull.points.push_back(at + (gap + 2 * width) * normal + (width * std::cos(2.0 * i)) * right +
                               (width * std::sin(2.0 * i)) * up);
  }
  return made;
}

/// Returns how many of 200 pairs of every kind of features are reported as overlapping.
int count_overlaps(double gap, double radius) {
  Random random(31);
  Scene bodies;
  std::vector<Hull> hulls;
  for (int i = 0; i < 1800; ++i) {
    const int layer = i / 144;
    const Vec3d centre = {4.0 * (i % 12), 4.0 * (i / 12 % 12), 4.0 * layer};
    Facing made = facing(random, centre, 1 + i % 3, 1 + i / 3 % 3, gap + radius);
    bodies.push_back(still(made.triangle, {}));
    made.hull.radius = radius;
    hulls.push_back(made.hull);
  }
  ProbedBodies probed(std::move(bodies));
  const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(queries_of(hulls));
  int count = 0;
  for (std::uint32_t i = 0; i < hulls.size(); ++i) {
    const bool is_found = std::any_of(found[i].begin(), found[i].end(),
                                      [&](const TriangleOverlap& one) { return one.body == probed.ids[i]; });
    count += is_found ? 1 : 0;
  }
  return count;
}

TEST(Hulls, that_are_apart_by_little_more_than_rounding_are_told_from_those_that_meet) {
  for (const double radius : {0.0, 0.25}) {
    for (const double gap : {1e-6, 1e-9, 1e-12}) {
      SCOPED_TRACE(testing::Message() << "radius " << radius << ", gap " << gap);
      EXPECT_EQ(count_overlaps(gap, radius), 0);
      EXPECT_EQ(count_overlaps(-gap, radius), 1800);
    }
  }
}

/// A prism around an axis, and the half-spaces of its inside.
struct Prism {
  Hull hull;
  std::vector<HalfSpace> sides;

  Prism(Random& random, Vec3d centre, double size, int side_count) {
    const Vec3d axis = random.direction();
    const Vec3d right = unit_vector(cross(axis, random.direction()));
    const Vec3d up = cross(axis, right);
    const double width = size * random.uniform(0.05, 1);
    const double half = size * random.uniform(0.05, 1);
    const auto around = [&](double part) {
      const double angle = 2 * 3.14159265358979323846 * part / side_count;
      return std::cos(angle) * right + std::sin(angle) * up;
    };
    for (int i = 0; i < side_count; ++i) {
      for (const double end : {-half, half}) hull.points.push_back(centre + width * around(i) + end * axis);
      const Vec3d normal = around(i + 0.5);
      sides.push_back({normal, dot(normal, centre) + width * std::cos(3.14159265358979323846 / side_count)});
    }
    for (const double end : {-1.0, 1.0}) sides.push_back({end * axis, dot(end * axis, centre) + half});
    for (int i = 0; i < 10; ++i) {
      hull.points.push_back(centre + (0.6 * width * random.unit()) * around(i) + (half * random.uniform(-1, 1)) * axis);
    }
  }
};

std::vector<ProbeHull> queries_of(const std::vector<Prism>& prisms) {
  std::vector<ProbeHull> queries;
  for (const Prism& prism : prisms) queries.push_back(prism.hull.query());
  return queries;
}

TEST(Hulls, of_many_points_overlap_what_is_between_their_sides) {
  const auto make = [](Random& random, double extent, const std::vector<PlacedTriangle>& /*triangles*/) {
    std::vector<Prism> prisms;
    for (int i = 0; i < 60; ++i) {
      const double size = std::exp2(random.uniform(-4, 0)) * extent;
      prisms.emplace_back(random, random.in_box(extent), size, 4 + int(random.below(30)));
    }
    return prisms;
  };
  const auto judge = [](const Prism& prism, const PlacedTriangle& t, double extent) {
    return verdict_on(t, prism.sides, 1e-10 * extent);
  };
  EXPECT_GT(compare_overlaps(10, make, judge), 1500U);
}

TEST(Hulls, of_one_and_two_points_are_spheres_and_capsules) {
  ProbedBodies probed({still(soup_with_everything(1), {}), still(grid_cloth(9, 7, 0.25), {})});
  Random random(12);
  std::vector<Hull> balls, rods;
  std::vector<ProbeSphere> spheres;
  std::vector<ProbeCapsule> capsules;
  for (int i = 0; i < 100; ++i) {
    spheres.push_back({random.in_box(2), random.uniform(0, 1)});
    balls.push_back({{spheres.back().centre}, spheres.back().radius});
    capsules.push_back({random.in_box(2), random.in_box(2), random.uniform(0, 0.5)});
    rods.push_back({{capsules.back().from, capsules.back().to}, capsules.back().radius});
  }
  const auto lists_of = [](const AnswerLists<TriangleOverlap>& answers) {
    std::vector<std::vector<TriangleOverlap>> lists;
    for (std::size_t i = 0; i < answers.size(); ++i) lists.push_back(copy_of(answers[i]));
    return lists;
  };
  const auto expect_same = [](const auto& a, const auto& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_TRUE(std::equal(a[i].begin(), a[i].end(), b[i].begin(), b[i].end(), are_same)) << "shape " << i;
    }
  };
  expect_same(lists_of(probed.probe.overlaps(spheres)), lists_of(probed.probe.overlaps(queries_of(balls))));
  expect_same(lists_of(probed.probe.overlaps(capsules)), lists_of(probed.probe.overlaps(queries_of(rods))));
}

TEST(Hulls, that_touch_on_a_grid_overlap) {
  ProbedBodies probed({still(one_triangle(), {}), still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
  std::vector<Hull> hulls;
  for (const PlacedTriangle& t : triangles) {
    hulls.push_back({{t.x[0]}});
    hulls.push_back({{t.x[1], t.x[2]}});
    hulls.push_back({{t.x[0], t.x[1], t.x[2]}});
    hulls.push_back({{t.x[0], t.x[0] + Vec3d{0, 0, 1}, t.x[1] + Vec3d{0, 0, 1}, t.x[2] + Vec3d{0, 0, 2}}});
  }
  const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(queries_of(hulls));
  for (std::size_t i = 0; i < hulls.size(); ++i) EXPECT_TRUE(has(found[i], triangles[i / 4])) << "hull " << i;
}

TEST(Hulls, that_are_none_overlap_nothing) {
  ProbedBodies probed({still(grid_cloth(3, 3, 1.0), {})});
  const std::vector<Hull> hulls = {{{{0, 0, 0}}, 1},
                                   {{}, 1},
                                   {{{0, 0, 0}, {kNaN, 0, 0}}, 1},
                                   {{{0, 0, 0}}, kNaN},
                                   {{{0, 0, 0}}, -1},
                                   {{{0, 0, 0}, {0, kInfinity, 0}}, 1},
                                   {{{0, 0, 0}, {0, 0, 1e38}}, 1},
                                   {{{9, 9, 9}}, kInfinity}};
  const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(queries_of(hulls));
  EXPECT_FALSE(found[0].empty());
  for (std::size_t i = 1; i < 7; ++i) EXPECT_TRUE(found[i].empty()) << "hull " << i;
  EXPECT_EQ(found[7].size(), probed.bodies[0].triangles.size());
  EXPECT_EQ(probed.probe.overlaps(Span<const ProbeHull>()).size(), 0U);
}

TEST(Hulls, overlap_what_is_there_when_they_are_asked_about) {
  const Mesh sheet = grid_cloth(3, 3, 1.0);
  SceneBody rope{{}, {{-1, 0, 0.5}, {1, 0, 0.5}}, {{-1, 0, 0.5}, {1, 0, 0.5}}, {}, {{{0, 1}}}};
  ProbedBodies probed({still(sheet, {}), rope});
  const Hull wedge = {{{0, -1, 0.25}, {0, 1, 0.25}, {0, 0, 0.75}}};
  const auto count = [&] {
    const ProbeHull query = wedge.query();
    return probed.probe.overlaps({&query, 1})[0].size();
  };
  EXPECT_EQ(count(), 1U) << "the rope's segment";
  const Mesh lifted = moved(sheet, {0.125, 0.125, 0.5});
  probed.scene.set_positions(probed.ids[0], lifted.positions);
  EXPECT_GT(count(), 2U);
  probed.scene.remove_body(probed.ids[0]);
  EXPECT_EQ(count(), 1U);
  probed.probe.set_body_filter([](BodyId) { return false; });
  EXPECT_EQ(count(), 0U);
  probed.scene.remove_body(probed.ids[1]);
  probed.probe.set_body_filter({});
  EXPECT_EQ(count(), 0U);
}

}  // namespace
}  // namespace softcd::test
