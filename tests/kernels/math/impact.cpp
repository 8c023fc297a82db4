#include "softcd/math/impact/impact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "queries.hpp"
#include "reference_distance.hpp"
#include "softcd/math/separation.hpp"

namespace softcd::test {
namespace {

constexpr std::array kKinds{ContactKind::vertex_triangle, ContactKind::edge_edge};

struct Tally {
  int queries = 0;
  int collisions = 0;
  int missed = 0;
  int false_alarms = 0;
  int beyond_tolerance = 0;  ///< hits whose distance at `time` exceeds the documented tolerance
};

template <class T>
Tally compare_with_exact(ContactKind kind, Family family, bool is_single, int count, double factor = 1.0) {
  Random random(static_cast<std::uint64_t>(family) * 101 + 13);
  Tally tally;
  for (int i = 0; i < count; ++i) {
    Query query = make_query(random, kind, family, is_single);
    query.rows = scaled(query.rows, factor);
    const bool is_collision = collides(query);
    const Impact<T> impact = impact_of<T>(query, T(0));
    const bool is_hit = impact.state == ImpactState::hit;
    ++tally.queries;
    tally.collisions += is_collision ? 1 : 0;
    tally.false_alarms += is_hit && !is_collision ? 1 : 0;
    if (is_collision && !is_hit && tally.missed++ == 0) {
      std::printf("first miss, %s: %s", name_of(family), to_string(query).c_str());
    }
    if (is_hit) {
      const double reach = 1.01 * documented_tolerance(query, static_cast<double>(epsilon<T>()));
      tally.beyond_tolerance += static_cast<double>(impact.distance) > reach ? 1 : 0;
    }
  }
  return tally;
}

void print(const char* arithmetic, ContactKind kind, Family family, const Tally& tally) {
  std::printf("%-16s %s %-12s %5d queries %5d collide %d missed %5d false alarms %d beyond tolerance\n", arithmetic,
              kind == ContactKind::vertex_triangle ? "VT" : "EE", name_of(family), tally.queries, tally.collisions,
              tally.missed, tally.false_alarms, tally.beyond_tolerance);
}

constexpr int kCount = 3'000;

class Impacts : public ::testing::TestWithParam<std::uint32_t> {
 protected:
  Family family() const { return static_cast<Family>(GetParam()); }
};

/// Float coordinates in double are the case for which `precise` is made.
TEST_P(Impacts, precise_misses_nothing_on_float_coordinates) {
  for (const ContactKind kind : kKinds) {
    const Tally tally = compare_with_exact<double>(kind, family(), true, kCount);
    print("double on float", kind, family(), tally);
    EXPECT_EQ(tally.missed, 0);
    EXPECT_LE(tally.beyond_tolerance, kCount / 500);
    // Distances between float coordinates are rarely below the tolerance of double without being 0.
    EXPECT_LE(tally.false_alarms, kCount / 500);
  }
}

TEST_P(Impacts, precise_misses_nothing_on_double_coordinates) {
  for (const ContactKind kind : kKinds) {
    const Tally tally = compare_with_exact<double>(kind, family(), false, kCount);
    print("double on double", kind, family(), tally);
    EXPECT_EQ(tally.missed, 0);
    EXPECT_LE(tally.beyond_tolerance, kCount / 500);
  }
}

TEST_P(Impacts, fast_misses_nothing_on_float_coordinates) {
  for (const ContactKind kind : kKinds) {
    const Tally tally = compare_with_exact<float>(kind, family(), true, kCount);
    print("float on float", kind, family(), tally);
    EXPECT_EQ(tally.missed, 0);
    EXPECT_LE(tally.beyond_tolerance, kCount / 500);
  }
}

/// Powers of two keep the verdicts: 1e-6, 1e6, and beyond the range of float's products.
TEST_P(Impacts, nothing_is_missed_at_other_scales) {
  for (const ContactKind kind : kKinds) {
    for (const double factor : {0x1p-20, 0x1p+20}) {
      EXPECT_EQ(compare_with_exact<double>(kind, family(), true, kCount / 4, factor).missed, 0) << factor;
    }
    for (const double factor : {0x1p-100, 0x1p-60, 0x1p-20, 0x1p+20, 0x1p+60, 0x1p+120}) {
      EXPECT_EQ(compare_with_exact<float>(kind, family(), true, kCount / 4, factor).missed, 0) << factor;
    }
  }
}

/// The figures of a hit agree with exact distances of the positions at its time.
TEST_P(Impacts, a_hit_describes_its_contact) {
  for (const ContactKind kind : kKinds) {
    Random random(GetParam() + 1);
    for (int i = 0; i < kCount; ++i) {
      const Query query = make_query(random, kind, family(), true);
      const double margin = i % 2 == 0 ? 0.0 : std::pow(10.0, -random.uniform(0.0, 6.0));
      const Impact<double> impact = impact_of<double>(query, margin);
      if (impact.state == ImpactState::separated) continue;
      ASSERT_GE(impact.time, 0.0);
      ASSERT_LE(impact.time, 1.0);
      ASSERT_NEAR(norm(impact.normal), 1.0, 1e-14) << to_string(query);
      const std::array<Vec3d, 4> p = rows_at(query.rows, impact.time);
      ASSERT_NEAR(impact.distance, std::sqrt(squared_distance(kind, p)), 1e-14) << to_string(query);
      Vec3d offset{0.0, 0.0, 0.0};
      for (std::size_t k = 0; k < 4; ++k) {
        const bool is_side_a = k < (kind == ContactKind::vertex_triangle ? 1u : 2u);
        offset = offset + (is_side_a ? impact.weights[k] : -impact.weights[k]) * p[k];
      }
      ASSERT_NEAR(norm(offset), impact.distance, 1e-14) << to_string(query);
      if (impact.distance > 1e-10) {
        ASSERT_NEAR(dot(offset, impact.normal), impact.distance, 1e-5 * impact.distance) << to_string(query);
      }
    }
  }
}

/// `time` is not later than the first contact: shortly before the time there is none.
TEST_P(Impacts, time_is_the_first_contact) {
  int checked = 0;
  for (const ContactKind kind : kKinds) {
    Random random(GetParam() + 31);
    for (int i = 0; i < kCount / 10; ++i) {
      const Query query = make_query(random, kind, family(), true);
      const Impact<double> impact = impact_of<double>(query, 0.0);
      if (impact.state == ImpactState::separated || impact.time == 0.0) continue;
      // A step that ends just before the impact, up to the rounding of its end points.
      Query shortened = query;
      const std::array<Vec3d, 4> before = rows_at(query.rows, impact.time * (1.0 - 1e-9));
      std::copy(before.begin(), before.end(), shortened.rows.begin() + 4);
      const double nearest = std::sqrt(squared_distance(kind, before));
      if (nearest < 1e-13) continue;
      ++checked;
      ASSERT_FALSE(collides(shortened)) << impact.time << "\n" << to_string(query);
    }
  }
  std::printf("%d impacts checked\n", checked);
}

/// All features that touch in exact arithmetic are hits, and all hits come within the margin.
TEST_P(Impacts, an_approach_misses_nothing) {
  for (const ContactKind kind : kKinds) {
    Random random(GetParam() * 101 + 13);
    Tally tally;
    int unsettled = 0;
    for (int i = 0; i < kCount; ++i) {
      const Query query = make_query(random, kind, family(), i % 2 == 0);
      const double margin = i % 4 < 2 ? 0.0 : std::pow(10.0, -random.uniform(0.0, 8.0));
      const bool is_collision = collides(query);
      const Impact<double> approach = approach_of(query, margin);
      const bool is_hit = approach.state != ImpactState::separated;
      ++tally.queries;
      tally.collisions += is_collision ? 1 : 0;
      // Distances between float coordinates are rarely below the tolerance without being 0.
      tally.false_alarms += i % 4 == 0 && is_hit && !is_collision ? 1 : 0;
      unsettled += approach.state == ImpactState::unsettled ? 1 : 0;
      ASSERT_TRUE(is_hit || !is_collision) << to_string(query);
      if (approach.state == ImpactState::hit) {
        const double reach = margin * (1 + 0x1p-20) + 2.02 * documented_tolerance(query, epsilon<double>());
        tally.beyond_tolerance += approach.distance > reach ? 1 : 0;
      }
    }
    print("approach", kind, family(), tally);
    std::printf("%d unsettled\n", unsettled);
    EXPECT_EQ(tally.beyond_tolerance, 0);
    EXPECT_LE(tally.false_alarms, kCount / 200);
    EXPECT_LE(unsettled, kCount / 200);
  }
}

long double distance_at(const Query& query, double t) {
  const std::array<Vec3d, 4> p = rows_at(query.rows, t);
  return query.kind == ContactKind::vertex_triangle ? distance_vertex_triangle(p[0], p[1], p[2], p[3])
                                                    : distance_edge_edge(p[0], p[1], p[2], p[3]);
}

/// No earlier sampled time is within the margin.
TEST_P(Impacts, an_approach_is_never_late) {
  constexpr int kSamples = 24;
  int before = 0;
  for (const ContactKind kind : kKinds) {
    Random random(GetParam() + 57);
    for (int i = 0; i < kCount / 4; ++i) {
      const Query query = make_query(random, kind, family(), true);
      const double margin = std::pow(10.0, -random.uniform(0.0, 5.0));
      const Impact<double> approach = approach_of(query, margin);
      const double certain = margin - 2 * documented_tolerance(query, epsilon<double>());
      for (int sample = 0; sample <= kSamples; ++sample) {
        const double t = double(sample) / kSamples;
        if (approach.state != ImpactState::separated && t >= approach.time) break;
        ++before;
        ASSERT_GE(static_cast<double>(distance_at(query, t)), certain) << t << "\n" << to_string(query);
      }
    }
  }
  EXPECT_GT(before, kCount);
}

/// A vertex comes within the margin as it passes the corner of a triangle, and is coplanar with the triangle only when
/// it is closest.
TEST(Approach, finds_what_passes_by_within_the_margin) {
  const Query past_corner = {ContactKind::vertex_triangle,
                             {Vec3d{0.0, 1.0, 0.05},
                              {0.0, 0.0, 0.0},
                              {1.0, 0.0, -1.0},
                              {-1.0, 0.0, -1.0},
                              Vec3d{0.0, -1.0, 0.05},
                              {0.0, 0.0, 0.0},
                              {1.0, 0.0, -1.0},
                              {-1.0, 0.0, -1.0}}};
  const Impact<double> approach = approach_of(past_corner, 0.1);
  EXPECT_EQ(approach.state, ImpactState::hit);
  EXPECT_NEAR(approach.time, 0.5 - 0.5 * std::sqrt(0.01 - 0.0025), 1e-6);
  EXPECT_LE(approach.time, 0.5 - 0.5 * std::sqrt(0.01 - 0.0025)) << "late";
  EXPECT_NEAR(approach.distance, 0.1, 1e-7);
  EXPECT_EQ(approach_of(past_corner, 0.049).state, ImpactState::separated);
}

TEST_P(Impacts, same_verdict_for_every_order_of_the_corners) {
  for (const ContactKind kind : kKinds) {
    Random random(GetParam() + 51);
    for (int i = 0; i < kCount; ++i) {
      const Query query = make_query(random, kind, family(), true);
      const Rows& r = query.rows;
      const Query other = kind == ContactKind::vertex_triangle
                              ? Query{kind, {r[0], r[3], r[1], r[2], r[4], r[7], r[5], r[6]}}
                              : Query{kind, {r[3], r[2], r[0], r[1], r[7], r[6], r[4], r[5]}};
      const Impact<double> first = impact_of<double>(query, 0.0);
      const Impact<double> second = impact_of<double>(other, 0.0);
      if (first.state != second.state) {
        // Both are within their guarantee only when the features do not touch.
        ASSERT_FALSE(collides(query)) << to_string(query);
      }
    }
  }
}

template <ContactKind kKind>
void expect_rejections_are_certain(Family family) {
  Random random(static_cast<std::uint64_t>(family) + 71);
  int lie_apart_count = 0;
  int keep_apart_count = 0;
  int apart_in_a_direction_count = 0;
  for (int i = 0; i < 5 * kCount; ++i) {
    const Query query = make_query(random, kKind, family, true);
    const double margin =
        i % 2 == 0 ? 0.0 : static_cast<double>(static_cast<float>(std::pow(10.0, -random.uniform(0.0, 6.0))));
    PointMotion<4> motion{};
    auto& [t0, t1] = motion;
    std::array<Vec3d, 4> start{};
    std::array<Vec3d, 4> end{};
    for (std::size_t k = 0; k < 4; ++k) {
      start[k] = query.rows[k];
      end[k] = query.rows[k + 4];
      t0[k] = vec3_cast<float>(start[k]);
      t1[k] = vec3_cast<float>(end[k]);
    }
    // The exact squared distance is rounded towards zero once, the margin's square once.
    const auto is_beyond = [&](const std::array<Vec3d, 4>& points) {
      return squared_distance(kKind, points) > margin * margin * (1.0 - 1e-15);
    };
    if (certainly_apart<kKind>(t0, static_cast<float>(margin))) {
      ++lie_apart_count;
      ASSERT_TRUE(is_beyond(start)) << to_string(query);
    }
    if (certainly_apart_when_coplanar<kKind>(t0, t1, static_cast<float>(margin))) {
      ++keep_apart_count;
      ASSERT_FALSE(collides(query)) << to_string(query);
      ASSERT_TRUE(is_beyond(start) && is_beyond(end)) << to_string(query);
    }
    if (certainly_apart_in_a_direction<kKind, false>(motion, static_cast<float>(margin))) {
      ASSERT_TRUE(is_beyond(end)) << to_string(query);
    }
    if (certainly_apart_in_a_direction<kKind, true>(motion, static_cast<float>(margin))) {
      ++apart_in_a_direction_count;
      ASSERT_FALSE(collides(query)) << to_string(query);
      for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        std::array<Vec3d, 4> between{};
        for (std::size_t k = 0; k < 4; ++k) between[k] = interpolate(start[k], end[k], t);
        ASSERT_TRUE(is_beyond(between)) << to_string(query) << " at " << t;
      }
    }
  }
  std::printf("%s: %d lie apart, %d keep apart, %d apart in a direction, of %d\n", name_of(family), lie_apart_count,
              keep_apart_count, apart_in_a_direction_count, 5 * kCount);
  if (family == Family::random) {
    EXPECT_GT(lie_apart_count, kCount);
    EXPECT_GT(keep_apart_count, kCount / 4);
    EXPECT_GT(apart_in_a_direction_count, kCount / 4);
  }
}

/// Features that are rejected in float before the narrow phase are apart in exact arithmetic.
TEST_P(Impacts, cheap_rejections_are_certain) {
  expect_rejections_are_certain<ContactKind::vertex_triangle>(family());
  expect_rejections_are_certain<ContactKind::edge_edge>(family());
}

INSTANTIATE_TEST_SUITE_P(Families, Impacts, ::testing::Range(0u, kFamilies),
                         [](const auto& suite) { return name_of(static_cast<Family>(suite.param)); });

/// Returns a vertex that falls from height 1 to -1 at (x, y), over the triangle (0, 0), (1, 0), (0, 1) at rest.
Query falling_at(double x, double y) {
  const Vec3d f0{0.0, 0.0, 0.0};
  const Vec3d f1{1.0, 0.0, 0.0};
  const Vec3d f2{0.0, 1.0, 0.0};
  return {ContactKind::vertex_triangle, {Vec3d{x, y, 1.0}, f0, f1, f2, Vec3d{x, y, -1.0}, f0, f1, f2}};
}

TEST(Impact, a_vertex_through_a_triangle) {
  const Impact<double> impact = impact_of<double>(falling_at(0.25, 0.5), 0.0);
  ASSERT_EQ(impact.state, ImpactState::hit);
  EXPECT_NEAR(impact.time, 0.5, 1e-12);
  EXPECT_LE(impact.time, 0.5);
  EXPECT_NEAR(impact.weights[0], 1.0, 0.0);
  EXPECT_NEAR(impact.weights[1], 0.25, 1e-12);
  EXPECT_NEAR(impact.weights[2], 0.25, 1e-12);
  EXPECT_NEAR(impact.weights[3], 0.5, 1e-12);
  EXPECT_NEAR(impact.normal.z, 1.0, 1e-12);
}

TEST(Impact, the_normal_points_to_where_side_a_came_from) {
  Query query = falling_at(0.25, 0.5);
  for (const double margin : {0.0, 1e-6}) {
    EXPECT_NEAR(impact_of<double>(query, margin).normal.z, 1.0, 1e-12);
    std::swap(query.rows[2], query.rows[3]);
    std::swap(query.rows[6], query.rows[7]);
    EXPECT_NEAR(impact_of<double>(query, margin).normal.z, 1.0, 1e-12) << "whatever the triangle's orientation";
    std::swap(query.rows[0], query.rows[4]);
    EXPECT_NEAR(impact_of<double>(query, margin).normal.z, -1.0, 1e-12);
    std::swap(query.rows[0], query.rows[4]);
  }
  query.rows[0].z = 0.0;
  EXPECT_NEAR(impact_of<double>(query, 0.0).normal.z, 1.0, 1e-12) << "on the plane at t0: against the motion";
}

TEST(Impact, the_normal_of_a_motion_in_the_plane) {
  Query query = falling_at(0.0, 0.0);
  query.rows[0] = {-1.0, 0.25, 0.0};
  query.rows[4] = {1.0, 0.25, 0.0};
  const Impact<double> impact = impact_of<double>(query, 0.0);
  ASSERT_EQ(impact.state, ImpactState::hit);
  EXPECT_NEAR(impact.time, 0.5, 1e-12);
  EXPECT_NEAR(impact.normal.x, -1.0, 1e-12);
}

TEST(Impact, the_margin_counts_at_both_ends) {
  Query query = falling_at(0.25, 0.25);
  query.rows[4].z = 0.5;
  EXPECT_EQ(impact_of<double>(query, 0.49).state, ImpactState::separated);
  const Impact<double> at_end = impact_of<double>(query, 0.51);
  ASSERT_EQ(at_end.state, ImpactState::hit);
  EXPECT_EQ(at_end.time, 1.0);
  EXPECT_NEAR(at_end.distance, 0.5, 1e-15);
  const Impact<double> at_start = impact_of<double>(query, 1.0);
  ASSERT_EQ(at_start.state, ImpactState::hit);
  EXPECT_EQ(at_start.time, 0.0);
}

TEST(Impact, the_margin_counts_beside_the_triangle) {
  EXPECT_EQ(impact_of<double>(falling_at(-0.1, 0.5), 0.09).state, ImpactState::separated);
  const Impact<double> impact = impact_of<double>(falling_at(-0.1, 0.5), 0.11);
  ASSERT_EQ(impact.state, ImpactState::hit);
  EXPECT_NEAR(impact.time, 0.5, 1e-12);
  EXPECT_NEAR(impact.distance, 0.1, 1e-12);
  EXPECT_NEAR(impact.normal.x, -1.0, 1e-9);
}

TEST(Impact, a_turning_edge_that_touches_and_leaves) {
  const auto turning = [](double lift) {
    return Query{ContactKind::vertex_triangle,
                 {Vec3d{0, -0.5, -lift}, Vec3d{-1, -2, 1}, Vec3d{3, -1, 0.5}, Vec3d{-1, 3, -1.5}, Vec3d{0, 0.5, -lift},
                  Vec3d{-1, -2, -1}, Vec3d{3, -1, -0.5}, Vec3d{-1, 3, 1.5}}};
  };
  const Impact<double> impact = impact_of<double>(turning(0.0), 0.0);
  ASSERT_EQ(impact.state, ImpactState::hit);
  EXPECT_NEAR(impact.time, 0.5, 1e-6);
  EXPECT_EQ(impact_of<double>(turning(1e-12), 0.0).state, ImpactState::separated);
  EXPECT_EQ(impact_of<float>(turning(1e-3), 0.0F).state, ImpactState::separated);
}

/// Finite input never gives NaN, a weight outside [0, 1] or a normal that is not one.
template <class T>
void expect_sane(double lowest_exponent, double highest_exponent) {
  Random random(5);
  for (int i = 0; i < 100'000; ++i) {
    Query query{i % 2 == 0 ? ContactKind::vertex_triangle : ContactKind::edge_edge, {}};
    const double common = random.uniform(lowest_exponent, highest_exponent);
    for (std::size_t k = 0; k < 8; ++k) {
      const double exponent = random.chance(0.3) ? random.uniform(lowest_exponent, highest_exponent) : common;
      Vec3d& p = query.rows[k];
      p = std::pow(10.0, exponent) * random.in_box(1.0);
      if (random.chance(0.1)) p.x = 0.0;
      if (random.chance(0.1)) p.y = 0.0;
      if (random.chance(0.1)) p = query.rows[random.below(8)];
    }
    const T margin = random.chance(0.5) ? T(0) : static_cast<T>(std::pow(10.0, random.uniform(-6.0, 6.0)));
    const Impact<T> impact = impact_of<T>(query, margin);
    if (impact.state == ImpactState::separated) continue;
    ASSERT_TRUE(impact.time >= T(0) && impact.time <= T(1)) << to_string(query);
    ASSERT_TRUE(std::isfinite(impact.distance)) << to_string(query);
    ASSERT_NEAR(static_cast<double>(norm(impact.normal)), 1.0, 1e-5) << to_string(query);
    for (const T w : impact.weights) ASSERT_TRUE(w >= T(0) && w <= T(1)) << to_string(query);
  }
}

TEST(Impact, every_magnitude_gives_sane_results) {
  expect_sane<float>(-44.0, 37.0);
  expect_sane<float>(-6.0, 6.0);
  expect_sane<double>(-300.0, 300.0);
}

}  // namespace
}  // namespace softcd::test
