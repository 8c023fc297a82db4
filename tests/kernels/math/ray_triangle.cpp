#include "softcd/math/ray_triangle.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "random.hpp"

// Compares rays and triangles with rational numbers.
namespace softcd::test {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Vector = std::array<Rational, 3>;
using Corners = std::array<Vec3f, 3>;

template <class T>
Vector exact(const Vec3<T>& x) {
  return {Rational(x.x), Rational(x.y), Rational(x.z)};
}

Vector minus(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Rational determinant(const Vector& a, const Vector& b, const Vector& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

struct ExactCrossing {
  bool is_crossed = false;
  Vector point;
  Rational t;
};

/// Returns the point at which the ray's line passes through the triangle; none where the line is coplanar with it.
ExactCrossing exact_crossing(const Ray& ray, const Corners& x) {
  const Vector origin = exact(ray.origin);
  const Vector direction = exact(ray.direction);
  Vector from[3];
  for (std::size_t i = 0; i < 3; ++i) from[i] = minus(exact(x[i]), origin);
  Rational sides[3];
  Rational whole = 0;
  bool has_negative = false, has_positive = false;
  for (std::size_t i = 0; i < 3; ++i) {
    sides[i] = determinant(direction, from[(i + 1) % 3], from[(i + 2) % 3]);
    whole += sides[i];
    has_negative |= sides[i] < 0;
    has_positive |= sides[i] > 0;
  }
  ExactCrossing crossing;
  crossing.is_crossed = has_negative != has_positive;
  if (!crossing.is_crossed) return crossing;
  const std::size_t axis = direction[0] != 0 ? 0 : (direction[1] != 0 ? 1 : 2);
  for (std::size_t k = 0; k < 3; ++k) {
    crossing.point[k] = (sides[0] * exact(x[0])[k] + sides[1] * exact(x[1])[k] + sides[2] * exact(x[2])[k]) / whole;
  }
  crossing.t = (crossing.point[axis] - origin[axis]) / direction[axis];
  return crossing;
}

/// Compares, and returns whether the ray passes through. `size` is the size of all coordinates.
bool compare(const Ray& ray, const Corners& x, double size) {
  ShearedRay sheared{};
  EXPECT_TRUE(shear(ray, {0, 0, 0}, sheared));
  const Vec3f corners[3] = {x[0], x[1], x[2]};
  RayCrossing crossing{};
  const bool is_crossed = find_crossing(sheared, corners, crossing);
  const ExactCrossing expected = exact_crossing(ray, x);
  EXPECT_EQ(is_crossed, expected.is_crossed);
  if (!is_crossed || !expected.is_crossed) return expected.is_crossed;
  const Vec3d on_ray = ray.origin + crossing.t * ray.direction;
  Vec3d on_triangle{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(crossing.weights[i], 0.0);
    EXPECT_LE(crossing.weights[i], 1.0);
    on_triangle = on_triangle + crossing.weights[i] * vec3_cast<double>(x[i]);
  }
  EXPECT_LE(max_norm(on_ray - on_triangle), 1e-7 * size);
  return true;
}

Vec3d grid_point(Random& random, std::uint32_t cells) {
  const auto coordinate = [&] { return double(random.below(2 * cells + 1)) - double(cells); };
  return {coordinate(), coordinate(), coordinate()};
}

Corners grid_triangle(Random& random, std::uint32_t cells) {
  Corners x{};
  for (Vec3f& corner : x) corner = vec3_cast<float>(grid_point(random, cells));
  return x;
}

TEST(RayTriangle, is_not_met_by_a_ray_in_its_plane) {
  const Corners seen_edge_on = {Vec3f{-2, 2, 1}, Vec3f{2, -1, -1}, Vec3f{1, 0, 0}};
  EXPECT_FALSE(compare({{1, -1, -2}, {-1, 2, 3}}, seen_edge_on, 3));
  const Corners without_area = {Vec3f{1, 1, -1}, Vec3f{1, 0, 0}, Vec3f{1, -1, 1}};
  EXPECT_FALSE(compare({{2, 2, 0}, {-2, -3, -1}}, without_area, 3));
}

TEST(RayTriangle, is_met_by_integer_rays_where_exact_arithmetic_says) {
  Random random(1);
  for (const std::uint32_t cells : {2U, 3U, 10U, 1000U}) {
    int met = 0;
    for (int i = 0; i < 3000 && !testing::Test::HasFailure(); ++i) {
      const Vec3d direction = grid_point(random, cells);
      if (max_norm(direction) == 0) continue;
      met += compare({grid_point(random, cells), direction}, grid_triangle(random, cells), cells) ? 1 : 0;
    }
    EXPECT_GT(met, 100);
  }
}

/// Neither origins nor their distances from vertices are floats.
TEST(RayTriangle, is_met_by_rays_through_its_corners_and_sides_where_exact_arithmetic_says) {
  Random random(2);
  int met = 0;
  for (int i = 0; i < 3000 && !testing::Test::HasFailure(); ++i) {
    Corners x{};
    for (Vec3f& corner : x) corner = vec3_cast<float>(random.in_box(1));
    const double distant = std::exp2(double(random.below(40)) - 10);
    const Vec3d origin = random.in_box(distant);
    const double u = random.below(3) == 0 ? 0 : random.uniform(-0.2, 1.2);
    const Vec3d target = (1 - u) * vec3_cast<double>(x[0]) + u * vec3_cast<double>(x[1]);
    met += compare({origin, target - origin}, x, 1 + distant) ? 1 : 0;
  }
  EXPECT_GT(met, 300);
}

TEST(RayTriangle, is_met_by_rays_almost_in_its_plane_where_exact_arithmetic_says) {
  Random random(3);
  int met = 0;
  for (int i = 0; i < 3000 && !testing::Test::HasFailure(); ++i) {
    Corners x{};
    for (Vec3f& corner : x) corner = vec3_cast<float>(random.in_box(1));
    const auto in_plane = [&](double size) {
      return vec3_cast<double>(x[0]) + random.uniform(-size, size) * vec3_cast<double>(x[1] - x[0]) +
             random.uniform(-size, size) * vec3_cast<double>(x[2] - x[0]);
    };
    const Vec3d origin = in_plane(4);
    met += compare({origin, in_plane(1) - origin}, x, 10) ? 1 : 0;
  }
  EXPECT_GT(met, 100);
}

TEST(RayTriangle, is_met_whatever_the_size_of_the_direction) {
  Random random(4);
  for (const double length : {0x1p-1000, 0x1p-500, 0x1p+500, 0x1p+1000}) {
    for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
      const Vec3d direction = grid_point(random, 3);
      if (max_norm(direction) == 0) continue;
      const Corners x = grid_triangle(random, 3);
      const Vec3d origin = grid_point(random, 3);
      ShearedRay sheared{};
      ASSERT_TRUE(shear({origin, length * direction}, {0, 0, 0}, sheared));
      const Vec3f corners[3] = {x[0], x[1], x[2]};
      RayCrossing crossing{};
      const bool is_crossed = find_crossing(sheared, corners, crossing);
      EXPECT_EQ(is_crossed, exact_crossing({origin, direction}, x).is_crossed);
      if (!is_crossed) continue;
      EXPECT_NEAR(crossing.t * length, static_cast<double>(exact_crossing({origin, direction}, x).t), 1e-12);
    }
  }
}

}  // namespace
}  // namespace softcd::test
