#include "exact_ccd.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "queries.hpp"

namespace softcd::test {
namespace {

/// Returns a vertex that falls from height 1 to -1 at (x, y), over the triangle (0, 0), (1, 0), (0, 1) at rest.
Rows falling_at(double x, double y) {
  const Vec3d f0{0.0, 0.0, 0.0};
  const Vec3d f1{1.0, 0.0, 0.0};
  const Vec3d f2{0.0, 1.0, 0.0};
  return {Vec3d{x, y, 1.0}, f0, f1, f2, Vec3d{x, y, -1.0}, f0, f1, f2};
}

TEST(ExactCcd, the_boundary_belongs_to_the_triangle_and_nothing_beyond_it) {
  EXPECT_TRUE(collides_vertex_triangle(falling_at(0.0, 0.0)));
  EXPECT_TRUE(collides_vertex_triangle(falling_at(0.5, 0.5)));
  EXPECT_TRUE(collides_vertex_triangle(falling_at(1.0, 0.0)));
  EXPECT_TRUE(collides_vertex_triangle(falling_at(0.25, 0.0)));
  EXPECT_FALSE(collides_vertex_triangle(falling_at(0.25, -0x1p-1074)));
  EXPECT_FALSE(collides_vertex_triangle(falling_at(0.5, 0.5 + 0x1p-53)));
}

TEST(ExactCcd, both_ends_of_the_step_count) {
  Rows rows = falling_at(0.25, 0.25);
  rows[4].z = 0.0;
  EXPECT_TRUE(collides_vertex_triangle(rows));
  rows[4].z = 0x1p-1074;
  EXPECT_FALSE(collides_vertex_triangle(rows));
  std::swap(rows[0], rows[4]);
  EXPECT_FALSE(collides_vertex_triangle(rows));
  rows[0].z = 0.0;
  EXPECT_TRUE(collides_vertex_triangle(rows));
}

TEST(ExactCcd, motion_in_one_plane) {
  Rows rows = falling_at(0.0, 0.0);
  rows[0] = {-1.0, 0.25, 0.0};
  rows[4] = {2.0, 0.25, 0.0};
  EXPECT_TRUE(collides_vertex_triangle(rows)) << "through the triangle";
  rows[4] = {-0.5, 0.25, 0.0};
  EXPECT_FALSE(collides_vertex_triangle(rows)) << "stops before it";
  rows[0] = {-1.0, 2.0, 0.0};
  rows[4] = {1.0, 0.0, 0.0};
  EXPECT_TRUE(collides_vertex_triangle(rows)) << "reaches a corner at the end of the step";
  rows[4] = {1.0, 0x1p-1074, 0.0};
  EXPECT_FALSE(collides_vertex_triangle(rows)) << "just does not";
  rows[0] = rows[4] = {0.25, 0.25, 0.0};
  EXPECT_TRUE(collides_vertex_triangle(rows)) << "rests inside";
}

TEST(ExactCcd, collinear_motion) {
  // All on the x axis: a point that follows a segment.
  const auto on_axis = [](double v0, double a0, double b0, double v1, double a1, double b1) {
    return Rows{Vec3d{v0, 0, 0}, Vec3d{a0, 0, 0}, Vec3d{b0, 0, 0}, Vec3d{a0, 0, 0},
                Vec3d{v1, 0, 0}, Vec3d{a1, 0, 0}, Vec3d{b1, 0, 0}, Vec3d{a1, 0, 0}};
  };
  EXPECT_TRUE(collides_vertex_triangle(on_axis(0, 1, 2, 3, 1, 2)));
  EXPECT_TRUE(collides_vertex_triangle(on_axis(0, 1, 2, 1, 1, 2)));
  EXPECT_FALSE(collides_vertex_triangle(on_axis(0, 1, 2, 1, 2, 3)));
  EXPECT_TRUE(collides_vertex_triangle(on_axis(0, 1, 2, 3, 4, 2.5)));
}

TEST(ExactCcd, a_touch_without_crossing) {
  // The height of the vertex over the turning plane is -(t - 1/2)^2: a double root, inside.
  const auto turning = [](double lift) {
    return Rows{Vec3d{0, -0.5, -lift}, Vec3d{-1, -2, 1},  Vec3d{3, -1, 0.5},  Vec3d{-1, 3, -1.5},
                Vec3d{0, 0.5, -lift},  Vec3d{-1, -2, -1}, Vec3d{3, -1, -0.5}, Vec3d{-1, 3, 1.5}};
  };
  EXPECT_TRUE(collides_vertex_triangle(turning(0.0)));
  EXPECT_FALSE(collides_vertex_triangle(turning(0x1p-1060)));
  EXPECT_TRUE(collides_vertex_triangle(turning(-0x1p-1060)));
}

TEST(ExactCcd, crossing_edges) {
  const auto crossing = [](double end) {
    return Rows{Vec3d{-1, 0, 1},  Vec3d{end, 0, 1},  Vec3d{0, -1, 0}, Vec3d{0, 1, 0},
                Vec3d{-1, 0, -1}, Vec3d{end, 0, -1}, Vec3d{0, -1, 0}, Vec3d{0, 1, 0}};
  };
  EXPECT_TRUE(collides_edge_edge(crossing(1.0)));
  EXPECT_TRUE(collides_edge_edge(crossing(0.0)));
  EXPECT_FALSE(collides_edge_edge(crossing(-0x1p-1074)));
}

TEST(ExactCcd, parallel_edges) {
  const auto falling = [](double from, double to) {
    return Rows{Vec3d{0, 0, 1},  Vec3d{1, 0, 1},  Vec3d{from, 0, 0}, Vec3d{to, 0, 0},
                Vec3d{0, 0, -1}, Vec3d{1, 0, -1}, Vec3d{from, 0, 0}, Vec3d{to, 0, 0}};
  };
  EXPECT_TRUE(collides_edge_edge(falling(0.5, 2.0)));
  EXPECT_TRUE(collides_edge_edge(falling(1.0, 2.0)));
  EXPECT_TRUE(collides_edge_edge(falling(-1.0, 2.0)));
  EXPECT_FALSE(collides_edge_edge(falling(1.0 + 0x1p-52, 2.0)));
}

TEST(ExactCcd, the_verdict_does_not_depend_on_the_order_of_the_corners) {
  for (std::uint32_t family = 0; family < kFamilies; ++family) {
    Random random(family + 21);
    for (int i = 0; i < 150; ++i) {
      const Query vt = make_query(random, ContactKind::vertex_triangle, static_cast<Family>(family), i % 2 == 0);
      const Rows& r = vt.rows;
      ASSERT_EQ(collides(vt), collides_vertex_triangle(Rows{r[0], r[2], r[3], r[1], r[4], r[6], r[7], r[5]}))
          << to_string(vt);
      ASSERT_EQ(collides(vt), collides_vertex_triangle(Rows{r[4], r[5], r[6], r[7], r[0], r[1], r[2], r[3]}))
          << to_string(vt);
      const Query ee = make_query(random, ContactKind::edge_edge, static_cast<Family>(family), i % 2 == 0);
      const Rows& s = ee.rows;
      ASSERT_EQ(collides(ee), collides_edge_edge(Rows{s[3], s[2], s[0], s[1], s[7], s[6], s[4], s[5]}))
          << to_string(ee);
    }
  }
}

/// Expects a narrow bracket around `time`.
void expect_at(const std::optional<TimeBracket>& bracket, double time) {
  ASSERT_TRUE(bracket);
  EXPECT_LE(bracket->lo, time);
  EXPECT_GE(bracket->hi, time);
  EXPECT_LE(bracket->hi - bracket->lo, 0x1p-42);
}

TEST(ExactCcd, the_first_contact_is_bracketed) {
  Rows rows = falling_at(0.25, 0.25);
  expect_at(first_contact_vertex_triangle(rows), 0.5);
  rows[4].z = -2.0;
  expect_at(first_contact_vertex_triangle(rows), 1.0 / 3.0);
  rows[4].z = 0.0;
  expect_at(first_contact_vertex_triangle(rows), 1.0);
  rows[0].z = 0.0;
  rows[4].z = 1.0;
  expect_at(first_contact_vertex_triangle(rows), 0.0);
  rows[0].z = 0x1p-60;
  EXPECT_FALSE(first_contact_vertex_triangle(rows));
}

TEST(ExactCcd, the_first_of_several_contacts_is_bracketed) {
  // In one plane: the vertex reaches the edges x = 0 and x + y = 1 of a triangle at 1/3 and 7/12.
  Rows planar = falling_at(0.0, 0.0);
  planar[0] = {-1.0, 0.25, 0.0};
  planar[4] = {2.0, 0.25, 0.0};
  expect_at(first_contact_vertex_triangle(planar), 1.0 / 3.0);
  std::swap(planar[0], planar[4]);
  expect_at(first_contact_vertex_triangle(planar), 5.0 / 12.0);
}

TEST(ExactCcd, brackets_agree_with_verdicts_and_distances) {
  for (std::uint32_t family = 0; family < kFamilies; ++family) {
    Random random(family + 77);
    for (int i = 0; i < 300; ++i) {
      const Query query = make_query(random, i % 2 == 0 ? ContactKind::vertex_triangle : ContactKind::edge_edge,
                                     static_cast<Family>(family), i % 4 < 2);
      const std::optional<TimeBracket> bracket = first_contact(query);
      ASSERT_EQ(bracket.has_value(), collides(query)) << to_string(query);
      if (!bracket) continue;
      ASSERT_LE(bracket->hi - bracket->lo, 0x1p-42);
      ASSERT_LT(squared_distance(query.kind, rows_at(query.rows, bracket->lo)), 1e-22) << to_string(query);
    }
  }
}

/// Verdicts for fractions do not use the floating-point filter with which those for doubles start.
TEST(ExactCcd, the_filter_agrees_with_rationals) {
  constexpr double kUnit = 0x1p-20;
  for (std::uint32_t family = 0; family < kFamilies; ++family) {
    Random random(family + 51);
    for (int i = 0; i < 400; ++i) {
      Query query = make_query(random, i % 2 == 0 ? ContactKind::vertex_triangle : ContactKind::edge_edge,
                               static_cast<Family>(family), true);
      std::array<Fraction, 24> fractions;
      for (std::size_t row = 0; row < 8; ++row) {
        const Vec3d& x = query.rows[row];
        const std::array<long long, 3> units = {std::llround(x.x / kUnit), std::llround(x.y / kUnit),
                                                std::llround(x.z / kUnit)};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          fractions[3 * row + axis] = {std::to_string(units[axis]), std::to_string(std::llround(1.0 / kUnit))};
        }
        query.rows[row] = {kUnit * double(units[0]), kUnit * double(units[1]), kUnit * double(units[2])};
      }
      const bool verdict = query.kind == ContactKind::vertex_triangle ? collides_vertex_triangle(fractions)
                                                                      : collides_edge_edge(fractions);
      ASSERT_EQ(collides(query), verdict) << to_string(query);
    }
  }
}

/// A simple second opinion: sampled exact distances. It can only confirm a contact, or that there is none anywhere
/// near.
TEST(ExactCcd, agrees_with_sampled_distances) {
  Random random(17);
  for (const ContactKind kind : {ContactKind::vertex_triangle, ContactKind::edge_edge}) {
    for (int i = 0; i < 200; ++i) {
      const Query query = make_query(random, kind, Family::random, true);
      constexpr int kSamples = 256;
      double nearest = 100.0;
      double speed = 0.0;
      for (std::size_t p = 0; p < 4; ++p) speed = std::max(speed, norm(query.rows[p + 4] - query.rows[p]));
      for (int sample = 0; sample <= kSamples; ++sample) {
        const double t = static_cast<double>(sample) / kSamples;
        nearest = std::min(nearest, std::sqrt(squared_distance(kind, rows_at(query.rows, t))));
      }
      // No distance changes faster than by twice the fastest vertex's speed.
      if (nearest > speed / kSamples) {
        ASSERT_FALSE(collides(query)) << to_string(query);
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test
