#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <utility>

#include "random.hpp"
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
