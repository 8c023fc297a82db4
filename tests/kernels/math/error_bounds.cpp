#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <utility>

#include "random.hpp"
#include "reference_distance.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/impact/impact.hpp"
#include "softcd/math/orientation.hpp"
#include "softcd/math/separation.hpp"

// Bounds of rounding errors where nearly all of them is needed.
namespace softcd::test {
namespace {

constexpr ContactKind kVertexTriangle = ContactKind::vertex_triangle;

struct VertexAboveNeedle {
  Vec3f x[4];
  Vec3d normal;  ///< towards the vertex
};

/// A triangle of length 1 and hardly any width, and a vertex at about this height above it.
VertexAboveNeedle vertex_above_needle(Random& random, double height) {
  const Vec3d along = random.direction();
  const Vec3d other = random.direction();
  const Vec3d normal = unit_vector(cross(along, other));
  const Vec3d across = std::exp2(random.uniform(-14.0, -8.0)) * cross(normal, along);
  const Vec3d corner = random.in_box(1.0);
  const Vec3d foot = corner + random.uniform(0.2, 0.6) * along + 0.1 * across;
  return {{vec3_cast<float>(foot + height * normal), vec3_cast<float>(corner), vec3_cast<float>(corner + along),
           vec3_cast<float>(corner + 0.7 * along + across)},
          normal};
}

double distance_of(const Vec3f (&x)[4]) {
  return closest_points_vertex_triangle(vec3_cast<double>(x[0]), vec3_cast<double>(x[1]), vec3_cast<double>(x[2]),
                                        vec3_cast<double>(x[3]))
      .distance();
}

// A needle's normal is mostly rounding, so that floats may compute a very wrong height above its plane.
TEST(ErrorBounds, no_vertex_within_the_margin_of_a_needle_is_lost) {
  Random random(1);
  constexpr float kMargin = 0.01F;
  int within = 0;
  for (int i = 0; i < 20000; ++i) {
    const double height = static_cast<double>(kMargin) * random.uniform(0.98, 1.0);
    const auto [end, normal] = vertex_above_needle(random, height);
    if (distance_of(end) > static_cast<double>(kMargin)) continue;
    ++within;
    const Vec3f begin[4] = {vec3_cast<float>(vec3_cast<double>(end[0]) + normal), end[1], end[2], end[3]};
    const PointMotion<4> motion{{begin[0], begin[1], begin[2], begin[3]}, {end[0], end[1], end[2], end[3]}};
    ASSERT_FALSE(certainly_apart<kVertexTriangle>(end, kMargin)) << i;
    ASSERT_FALSE((certainly_apart_in_a_direction<kVertexTriangle, false>(motion, kMargin))) << i;
    ASSERT_FALSE((certainly_apart_in_a_direction<kVertexTriangle, true>(motion, kMargin))) << i;
    ASSERT_FALSE(certainly_apart_throughout<kVertexTriangle>(begin, end, kMargin)) << i;
    ASSERT_FALSE(certainly_apart_when_coplanar<kVertexTriangle>(begin, end, kMargin)) << i;
    ASSERT_NE(first_coplanar_impact<kVertexTriangle>(begin, end, kMargin).state, ImpactState::separated) << i;
  }
  EXPECT_GT(within, 10000);
}

using RelativeFloats = detail::RelativePair<float>;

/// Returns by how much the computed distance exceeds the exact one, in epsilon (A + B + C).
template <ContactKind kKind>
double excess_of_distance(const RelativeFloats& pair) {
  const Vec3d a = vec3_cast<double>(pair.a), b = vec3_cast<double>(pair.b), c = vec3_cast<double>(pair.c);
  const double size = max_norm(a) + max_norm(b) + max_norm(c);
  const Vec3d origin{0, 0, 0};
  const long double exact =
      kKind == kVertexTriangle ? distance_vertex_triangle(a, origin, b, c) : distance_edge_edge(a, a + b, origin, c);
  const float computed = square_root(detail::nearest<kKind>(pair).squared_distance);
  return size > 0 ? static_cast<double>(static_cast<long double>(computed) - exact) / (size * epsilon<float>()) : 0.0;
}

/// Returns features that are needles or short, nearly parallel, far apart or near each other.
RelativeFloats hard_pair(Random& random) {
  const auto length = [&](double least_exponent) { return std::exp2(least_exponent * random.unit()); };
  const Vec3d b = (random.below(3) == 0 ? length(-20) : 1.0) * random.in_box(1.0);
  const Vec3d c =
      (random.below(8) == 0 ? length(-20) : 1.0) *
      (random.below(4) == 0 ? random.in_box(1.0) : random.uniform(-1.0, 1.0) * b + length(-40) * random.in_box(1.0));
  const Vec3d a = random.uniform(-1.2, 1.2) * b + random.uniform(-1.2, 1.2) * c +
                  (random.below(5) == 0 ? 1.0 : length(-40)) * random.in_box(1.0);
  return {vec3_cast<float>(a), vec3_cast<float>(b), vec3_cast<float>(c)};
}

/// Changes one to three coordinates, by much or by little.
RelativeFloats nudged(Random& random, RelativeFloats pair) {
  float* const coordinates[9] = {&pair.a.x, &pair.a.y, &pair.a.z, &pair.b.x, &pair.b.y,
                                 &pair.b.z, &pair.c.x, &pair.c.y, &pair.c.z};
  for (std::uint32_t change = random.below(3) + 1; change > 0; --change) {
    float& x = *coordinates[random.below(9)];
    const double size = random.below(3) == 0 ? 1.0 : static_cast<double>(magnitude(x));
    const double moved = static_cast<double>(x) + std::exp2(-26 * random.unit()) * size * random.uniform(-1.0, 1.0);
    x = random.below(32) == 0 ? 0.0F : static_cast<float>(std::clamp(moved, -1.0, 1.0));
  }
  return pair;
}

template <ContactKind kKind>
double largest_excess(Random& random, int starts) {
  double largest = 0;
  for (int start = 0; start < starts; ++start) {
    RelativeFloats pair = hard_pair(random);
    double excess = excess_of_distance<kKind>(pair);
    for (int failures = 0; failures < 200; ++failures) {
      const RelativeFloats other = nudged(random, pair);
      const double of_other = excess_of_distance<kKind>(other);
      if (of_other < excess) continue;
      if (of_other > excess) failures = 0;
      pair = other;
      excess = of_other;
    }
    largest = std::max(largest, excess);
  }
  return largest;
}

// tests/proofs/roundings.py takes it that no distance is 8 epsilon (A + B + C) too large. From each start this climbs
// to a case that is worse than all those around it.
TEST(ErrorBounds, nearest_points_are_hardly_further_apart_than_the_features) {
  Random random(2);
  const double of_vertices = largest_excess<kVertexTriangle>(random, 100);
  const double of_edges = largest_excess<ContactKind::edge_edge>(random, 100);
  EXPECT_LT(of_vertices, 4.0);
  EXPECT_LT(of_edges, 4.0);
  EXPECT_GT(std::min(of_vertices, of_edges), 1.0) << "the search finds no roundings";
}

using Integer = boost::multiprecision::cpp_int;
using IntegerVector = std::array<Integer, 3>;

Integer dot_of(const IntegerVector& a, const IntegerVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// a x + b y = gcd
struct Bezout {
  Integer gcd, x, y;
};
Bezout bezout(Integer a, Integer b) {
  Integer x = 1, y = 0, next_x = 0, next_y = 1;
  while (b != 0) {
    const Integer quotient = a / b;
    a = std::exchange(b, Integer(a - quotient * b));
    x = std::exchange(next_x, Integer(x - quotient * next_x));
    y = std::exchange(next_y, Integer(y - quotient * next_y));
  }
  return {a, x, y};
}

/// Returns w less multiples of u and v, so that little of it is left along both.
IntegerVector reduced(IntegerVector w, const IntegerVector& u, const IntegerVector& v) {
  const Integer uu = dot_of(u, u), uv = dot_of(u, v), vv = dot_of(v, v);
  const Integer whole = uu * vv - uv * uv;
  const Integer wu = dot_of(w, u), wv = dot_of(w, v);
  const Integer along_u = (wu * vv - wv * uv) / whole;
  const Integer along_v = (wv * uu - wu * uv) / whole;
  for (std::size_t axis = 0; axis < 3; ++axis) w[axis] -= along_u * u[axis] + along_v * v[axis];
  return w;
}

// A third edge has the least possible volume with edges u and v. The terms of that volume are 10^20 times as large, so
// double computes nothing but roundings.
TEST(ErrorBounds, the_least_volumes_of_integers_have_their_sign) {
  Random random(3);
  const auto integer = [&] { return Integer(static_cast<std::int64_t>(random.below(1U << 23)) - (1 << 22)); };
  const auto in_float = [](const IntegerVector& x) {
    return Vec3f{static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
  };
  for (int i = 0; i < 3000; ++i) {
    const IntegerVector u = {integer(), integer(), integer()};
    const IntegerVector v = {integer(), integer(), integer()};
    const IntegerVector n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const Bezout of_two = bezout(n[0], n[1]);
    const Bezout of_all = bezout(of_two.gcd, n[2]);
    const IntegerVector w = reduced({of_all.x * of_two.x, of_all.x * of_two.y, of_all.y}, u, v);
    ASSERT_EQ(dot_of(n, w), of_all.gcd);
    const int sign = of_all.gcd > 0 ? 1 : -1;
    ASSERT_EQ(orientation(in_float(u), in_float(v), in_float(w), {0, 0, 0}), sign) << i;
    ASSERT_EQ(orientation(in_float(v), in_float(u), in_float(w), {0, 0, 0}), -sign) << i;
  }
}

}  // namespace
}  // namespace softcd::test
