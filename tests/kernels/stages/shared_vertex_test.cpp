#include "softcd/stages/shared_vertex_test.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "random.hpp"

namespace softcd::test {
namespace {

/// The five vertices of the triangles 0 1 2 and 0 3 4.
struct Pair {
  std::array<Vec3f, 5> x_t0, x_t1;

  Vec3d at(std::size_t v, double time) const {
    return lerp(vec3_cast<double>(x_t0[v]), vec3_cast<double>(x_t1[v]), time);
  }
  void shift(std::size_t v, Vec3d by) {
    x_t0[v] = vec3_cast<float>(vec3_cast<double>(x_t0[v]) + by);
    x_t1[v] = vec3_cast<float>(vec3_cast<double>(x_t1[v]) + by);
  }
};

template <bool kSwept>
bool may_touch(const Pair& pair, float distance) {
  SceneView scene;
  scene.x_t0 = pair.x_t0.data();
  scene.x_t1 = pair.x_t1.data();
  scene.is_swept = kSwept;
  const SharedVertexTest<kSwept> test{scene};
  const Triangle a{{1, 2, 0}};
  const Triangle b{{3, 0, 4}};
  const bool answer = test.may_touch(a, b, distance);
  EXPECT_EQ(test.may_touch(b, a, distance), answer);
  return answer;
}

Pair random_pair(Random& random) {
  const double size = std::ldexp(1.0, static_cast<int>(random.below(60)) - 30);
  const Vec3d centre = size * random.in_box(random.chance(0.5) ? 0.0 : 100.0);
  const double speed = random.chance(0.3) ? 0.0 : 2.0;
  Pair pair{};
  for (std::size_t v = 0; v < 5; ++v) {
    const Vec3d start = centre + size * random.in_box(1.0);
    pair.x_t0[v] = vec3_cast<float>(start);
    pair.x_t1[v] = vec3_cast<float>(start + (size * speed) * random.in_box(1.0));
  }
  return pair;
}

/// Returns the largest coordinate.
double furthest_of(const Pair& pair) {
  float furthest = 0.0F;
  for (std::size_t v = 0; v < 5; ++v)
    furthest = larger(furthest, larger(max_norm(pair.x_t0[v]), max_norm(pair.x_t1[v])));
  return static_cast<double>(furthest);
}

/// A point of the edge 1 2, which lacks the shared vertex, minus a point of the triangle 0 3 4, as weights of all
/// vertices.
struct Meeting {
  double weights[5];
  double time;
};

Meeting random_meeting(Random& random) {
  const double along = random.chance(0.3) ? 0.0 : random.unit();
  const double first = random.unit();
  const double second = random.unit() * (1.0 - first);
  return {{-(1.0 - first - second), 1.0 - along, along, -first, -second}, random.chance(0.3) ? 1.0 : random.unit()};
}

/// Moves the edge so that the vector between the meeting's points becomes `offset`.
void bring_together(Pair& pair, const Meeting& meeting, Vec3d offset) {
  Vec3d between{0, 0, 0};
  for (std::size_t v = 0; v < 5; ++v) between = between + meeting.weights[v] * pair.at(v, meeting.time);
  for (const std::size_t v : {1U, 2U}) pair.shift(v, offset - between);
}

TEST(SharedVertexTest, keeps_what_comes_within_the_distance) {
  Random random(1);
  for (int i = 0; i < 200000; ++i) {
    Pair pair = random_pair(random);
    const Meeting meeting = random_meeting(random);
    const double distance =
        random.chance(0.3) ? 0.0 : furthest_of(pair) * std::ldexp(1.0, -static_cast<int>(random.below(12)));
    bring_together(pair, meeting, (0.99 * distance) * random.direction());
    // Positions were rounded after the points were brought together.
    const auto reach = static_cast<float>(distance + 1e-6 * furthest_of(pair));
    ASSERT_TRUE(may_touch<true>(pair, reach)) << "pair " << i;
    ASSERT_TRUE(meeting.time < 1.0 || may_touch<false>(pair, reach)) << "pair " << i;
  }
}

Vec3d whole_numbers(Random& random, double half_size) {
  const Vec3d p = random.in_box(half_size);
  return {std::round(p.x), std::round(p.y), std::round(p.z)};
}

// The middle of the edge 1 2 is exactly vertex 3, and the edge stands on the triangle 0 3 4.
TEST(SharedVertexTest, keeps_what_touches_however_it_is_rounded) {
  Random random(2);
  for (int i = 0; i < 200000; ++i) {
    const double size = std::ldexp(1.0, static_cast<int>(random.below(6)) + 4);
    const Vec3d hub = whole_numbers(random, 1e5);
    const Vec3d side = whole_numbers(random, size);
    const Vec3d other_side = whole_numbers(random, size);
    const Vec3d corner = hub + side;
    const Vec3d far_corner = hub + other_side;
    const Vec3d half = cross(side, other_side);
    Pair pair{};
    pair.x_t1 = {vec3_cast<float>(hub), vec3_cast<float>(corner + half), vec3_cast<float>(corner - half),
                 vec3_cast<float>(corner), vec3_cast<float>(far_corner)};
    pair.x_t0 = pair.x_t1;
    ASSERT_TRUE(may_touch<false>(pair, 0.0F)) << "pair " << i;
    ASSERT_TRUE(may_touch<true>(pair, 0.0F)) << "pair " << i;
  }
}

/// Returns triangles whose opposite edges are 2 scale apart.
Pair flat_pair(double scale, Vec3d shift_t1) {
  Pair pair{};
  const std::array<Vec3d, 5> x{{{0, 0, 0}, {8, 1, 0}, {8, 2, 0}, {8, -1, 0}, {8, -2, 0}}};
  for (std::size_t v = 0; v < 5; ++v) {
    pair.x_t0[v] = vec3_cast<float>(scale * x[v]);
    pair.x_t1[v] = vec3_cast<float>(scale * (x[v] + shift_t1));
  }
  return pair;
}

TEST(SharedVertexTest, lets_go_what_stays_apart_at_any_scale) {
  for (const float scale : {1.0F, 1e-30F, 1e+30F}) {
    for (const Vec3d shift : {Vec3d{0, 0, 0}, Vec3d{40, -30, 20}}) {
      const Pair pair = flat_pair(static_cast<double>(scale), shift);
      EXPECT_FALSE(may_touch<true>(pair, 0.9F * scale));
      EXPECT_FALSE(may_touch<false>(pair, 0.9F * scale));
      EXPECT_TRUE(may_touch<true>(pair, 2.1F * scale));
      EXPECT_TRUE(may_touch<false>(pair, 2.1F * scale));
    }
  }
}

TEST(SharedVertexTest, keeps_what_crosses_before_the_end) {
  Pair pair = flat_pair(1.0, {0, 0, 0});
  for (const std::size_t v : {1U, 2U}) pair.x_t0[v].y = -3.0F - pair.x_t0[v].y;
  EXPECT_TRUE(may_touch<true>(pair, 0.0F));
  EXPECT_FALSE(may_touch<false>(pair, 0.0F));
}

// For such triangles, edges at the two shared vertices remain.
TEST(SharedVertexTest, keeps_triangles_that_share_two_vertices) {
  const std::vector<Vec3f> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  SceneView scene;
  scene.x_t0 = scene.x_t1 = x.data();
  const SharedVertexTest<false> test{scene};
  EXPECT_TRUE(test.may_touch({{0, 1, 2}}, {{0, 1, 3}}, 0.0F));
  EXPECT_TRUE(test.may_touch({{2, 0, 1}}, {{3, 1, 0}}, 0.0F));
}

TEST(SharedVertexTest, keeps_segments_and_points_that_share_their_vertex) {
  const std::vector<Vec3f> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0.5F, 0, 0}};
  SceneView scene;
  scene.x_t0 = scene.x_t1 = x.data();
  const SharedVertexTest<false> test{scene};
  EXPECT_TRUE(test.may_touch({{0, 1, 1}}, {{0, 4, 2}}, 0.0F));
  EXPECT_TRUE(test.may_touch({{0, 0, 1}}, {{4, 2, 0}}, 0.0F));
  EXPECT_TRUE(test.may_touch({{0, 0, 0}}, {{0, 1, 2}}, 0.0F));
  EXPECT_FALSE(test.may_touch({{0, 2, 2}}, {{0, 3, 3}}, 0.5F));
  EXPECT_TRUE(test.may_touch({{0, 2, 2}}, {{0, 3, 3}}, 1.5F));
}

}  // namespace
}  // namespace softcd::test
