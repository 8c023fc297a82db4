#include "softcd/math/closest_point.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "exact_ccd.hpp"
#include "queries.hpp"
#include "reference_distance.hpp"

namespace softcd::test {
namespace {

using Points = std::array<Vec3d, 4>;

template <class T>
ClosestPoints<T> closest_points(ContactKind kind, const Points& points) {
  const std::array<Vec3<T>, 4> p{vec3_cast<T>(points[0]), vec3_cast<T>(points[1]), vec3_cast<T>(points[2]),
                                 vec3_cast<T>(points[3])};
  return kind == ContactKind::vertex_triangle ? closest_points_vertex_triangle(p[0], p[1], p[2], p[3])
                                              : closest_points_edge_edge(p[0], p[1], p[2], p[3]);
}

/// Returns the error of a distance, in epsilons of the points' extent.
template <class T>
double error_of(ContactKind kind, const Points& points) {
  const double distance = static_cast<double>(closest_points<T>(kind, points).distance());
  double extent = 0.0;
  for (const Vec3d& p : points) extent = std::max(extent, max_norm(p - points[3]));
  const double error = std::abs(distance - std::sqrt(squared_distance(kind, points)));
  return error == 0.0 ? 0.0 : error / (extent * static_cast<double>(epsilon<T>()));
}

Points rounded_to_float(Points points) {
  for (Vec3d& p : points) {
    volatile float x = static_cast<float>(p.x);
    volatile float y = static_cast<float>(p.y);
    volatile float z = static_cast<float>(p.z);
    p = {x, y, z};
  }
  return points;
}

/// Each coordinate of an offset takes five roundings of values within twice the extent.
constexpr double kFewRoundings = 8.0;

constexpr std::array kKinds{ContactKind::vertex_triangle, ContactKind::edge_edge};

TEST(ClosestPoints, distance_is_right_within_a_few_roundings) {
  for (const ContactKind kind : kKinds) {
    for (std::uint32_t family = 0; family < kFamilies; ++family) {
      Random random(family + 1);
      for (int i = 0; i < 2'000; ++i) {
        const Query query = make_query(random, kind, static_cast<Family>(family), true);
        const Points points{query.rows[0], query.rows[1], query.rows[2], query.rows[3]};
        ASSERT_LT(error_of<double>(kind, points), kFewRoundings) << to_string(query);
        ASSERT_LT(error_of<float>(kind, points), kFewRoundings) << to_string(query);
      }
    }
  }
}

TEST(ClosestPoints, exact_distance_agrees_with_the_reference) {
  Random random(7);
  for (int i = 0; i < 2'000; ++i) {
    Points p;
    for (Vec3d& point : p) point = random.in_box(1.0);
    EXPECT_NEAR(std::sqrt(squared_distance_vertex_triangle(p)),
                static_cast<double>(distance_vertex_triangle(p[0], p[1], p[2], p[3])), 1e-15);
    EXPECT_NEAR(std::sqrt(squared_distance_edge_edge(p)),
                static_cast<double>(distance_edge_edge(p[0], p[1], p[2], p[3])), 1e-15);
  }
}

TEST(ClosestPoints, weights_and_offset_describe_the_same_points) {
  Random random(3);
  for (const ContactKind kind : kKinds) {
    for (std::uint32_t family = 0; family < kFamilies; ++family) {
      for (int i = 0; i < 5'000; ++i) {
        const Query query = make_query(random, kind, static_cast<Family>(family), false);
        const Points p{query.rows[4], query.rows[5], query.rows[6], query.rows[7]};
        const ClosestPoints<double> result = closest_points<double>(kind, p);
        const auto& w = result.weights;
        const std::size_t first_of_b = kind == ContactKind::vertex_triangle ? 1 : 2;
        std::array<double, 2> sums{0.0, 0.0};
        Vec3d offset{0.0, 0.0, 0.0};
        for (std::size_t k = 0; k < 4; ++k) {
          ASSERT_GE(w[k], 0.0) << to_string(query);
          ASSERT_LE(w[k], 1.0) << to_string(query);
          sums[k < first_of_b ? 0 : 1] += w[k];
          offset = offset + (k < first_of_b ? w[k] : -w[k]) * p[k];
        }
        ASSERT_NEAR(sums[0], 1.0, 4e-16);
        ASSERT_NEAR(sums[1], 1.0, 4e-16);
        ASSERT_LT(max_norm(offset - result.offset), 1e-14) << to_string(query);
        ASSERT_EQ(result.squared_distance, squared_norm(result.offset));
      }
    }
  }
}

TEST(ClosestPoints, a_vertex_is_near_up_to_its_distance) {
  for (std::uint32_t family = 0; family < kFamilies; ++family) {
    Random random(family + 1);
    for (int i = 0; i < 5'000; ++i) {
      const Query query = make_query(random, ContactKind::vertex_triangle, static_cast<Family>(family), false);
      const auto pair = detail::relative_vertex_triangle(query.rows[4], query.rows[5], query.rows[6], query.rows[7]);
      const double squared_distance = detail::nearest_vertex_triangle(pair).squared_distance;
      const detail::Nearest<double> foot = detail::nearest_in_plane(pair);
      ASSERT_TRUE(detail::is_vertex_near_triangle(pair, foot, squared_distance)) << to_string(query);
      if (!(squared_distance > 0.0)) continue;
      const double less = std::nextafter(squared_distance, 0.0);
      ASSERT_FALSE(detail::is_vertex_near_triangle(pair, foot, less)) << to_string(query);
    }
  }
}

/// Returns a vertex inside a flat triangle whose third corner is `height` away from the long edge, or from a corner.
Points flat_triangle(Random& random, double height) {
  const Vec3d f0 = random.in_box(1.0);
  const Vec3d f1 = random.in_box(1.0);
  const Vec3d f2 = (random.chance(0.5) ? f1 : lerp(f0, f1, random.unit())) + height * random.direction();
  const double x = random.unit();
  const double y = random.unit() * (1.0 - x);
  return {(1.0 - x - y) * f0 + x * f1 + y * f2, f0, f1, f2};
}

/// Returns two edges that cross inside, with directions that differ by `angle`.
Points almost_parallel_edges(Random& random, double angle) {
  const Vec3d g0 = random.in_box(1.0);
  const Vec3d g1 = random.in_box(1.0);
  const Vec3d along = (g1 - g0) + angle * random.direction();
  const Vec3d e0 = lerp(g0, g1, random.unit()) - random.unit() * along;
  return {e0, e0 + along, g0, g1};
}

TEST(ClosestPoints, the_error_does_not_grow_with_the_aspect) {
  for (double aspect = 1.0; aspect > 1e-16; aspect *= 0.1) {
    Random random(11);
    for (int i = 0; i < 500; ++i) {
      const Points triangle = flat_triangle(random, aspect);
      const Points edges = almost_parallel_edges(random, aspect);
      ASSERT_LT(error_of<double>(ContactKind::vertex_triangle, triangle), kFewRoundings) << aspect;
      ASSERT_LT(error_of<double>(ContactKind::edge_edge, edges), kFewRoundings) << aspect;
      ASSERT_LT(error_of<float>(ContactKind::vertex_triangle, rounded_to_float(triangle)), kFewRoundings) << aspect;
      ASSERT_LT(error_of<float>(ContactKind::edge_edge, rounded_to_float(edges)), kFewRoundings) << aspect;
    }
  }
}

TEST(ClosestPoints, powers_of_two_scale_the_result_exactly) {
  Random random(5);
  for (const ContactKind kind : kKinds) {
    for (int i = 0; i < 2'000; ++i) {
      const Query query = make_query(random, kind, Family::random, true);
      const Points p{query.rows[0], query.rows[1], query.rows[2], query.rows[3]};
      const ClosestPoints<float> plain = closest_points<float>(kind, p);
      for (const float factor : {0x1p-100F, 0x1p-50F, 0x1p-20F, 0x1p+40F, 0x1p+120F}) {
        Points q = p;
        for (Vec3d& point : q) point = static_cast<double>(factor) * point;
        const ClosestPoints<float> large = closest_points<float>(kind, q);
        for (int k = 0; k < 4; ++k) ASSERT_EQ(plain.weights[k], large.weights[k]) << factor;
        ASSERT_EQ((factor * large.scale / plain.scale) * plain.offset, large.offset) << factor;
        ASSERT_EQ(factor * plain.distance(), large.distance()) << factor;
      }
    }
  }
}

TEST(ClosestPoints, points_that_coincide) {
  const Vec3d p{0.1, -0.7, 3.0};
  const Points points{p, p, p, p};
  for (const ContactKind kind : kKinds) {
    EXPECT_EQ(closest_points<double>(kind, points).squared_distance, 0.0);
    EXPECT_EQ(closest_points<float>(kind, points).squared_distance, 0.0F);
  }
}

}  // namespace
}  // namespace softcd::test
