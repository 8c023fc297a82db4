#include "softcd/stages/vertex_stars.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "random_stars.hpp"
#include "reference_distance.hpp"

namespace softcd::test {
namespace {

/// The least distance of features of a star's triangles that share no vertex, at some times of the step. It is relative
/// to the distance within which they are in contact, unless that is 0.
class Oracle {
 public:
  Oracle(const RandomStars& scene, std::size_t star) : scene_(scene), first_(scene.stars[star].centre) {
    const Topology& mesh = scene.topologies[star];
    const NeighbourFeatures features = neighbour_features(view_of(mesh), mesh.ownership);
    const int steps = scene.view.is_swept ? 32 : 0;
    for (int step = 0; step <= steps; ++step) {
      const double time = steps == 0 ? 1.0 : static_cast<double>(step) / steps;
      const auto x = [&](std::uint32_t v) { return position(v, time); };
      for (const std::uint64_t pair : features.vertex_triangle) {
        const auto& t = mesh.triangles[pair & 0xFFFFFFFFU].v;
        add(distance_vertex_triangle(x(static_cast<std::uint32_t>(pair >> 32)), x(t[0]), x(t[1]), x(t[2])));
      }
      for (const std::uint64_t pair : features.edge_edge) {
        const auto& e = mesh.edges[pair >> 32].v;
        const auto& g = mesh.edges[pair & 0xFFFFFFFFU].v;
        add(distance_edge_edge(x(e[0]), x(e[1]), x(g[0]), x(g[1])));
      }
    }
  }

  double least() const { return least_; }

 private:
  void add(long double distance) { least_ = std::min(least_, static_cast<double>(distance)); }
  Vec3d position(std::uint32_t v, double time) const {
    const Vec3d x0 = vec3_cast<double>(scene_.view.x_t0[first_ + v]);
    const Vec3d x1 = vec3_cast<double>(scene_.view.x_t1[first_ + v]);
    return x0 + time * (x1 - x0);
  }

  const RandomStars& scene_;
  std::uint32_t first_;
  double least_ = 1e300;
};

std::vector<std::uint8_t> spread_of(const RandomStars& scene) {
  return scene.spread([](const TestStar& test, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) test(i);
  });
}

TEST(VertexStars, features_of_spread_stars_are_apart) {
  Random random(1);
  int spread_count = 0;
  int apart_count = 0;
  for (int round = 0; round < 300; ++round) {
    const RandomStars scene(random, 20, 1.0);
    const std::vector<std::uint8_t> spread = spread_of(scene);
    for (std::size_t i = 0; i < scene.stars.size(); ++i) {
      const VertexStar& star = scene.stars[i];
      const double margin = static_cast<double>(scene.bodies[i].margin);
      const double distance = (scene.view.contact_rule == ContactRule::slab ? std::sqrt(5.0) : 1.0) * 2.0 * margin;
      const bool are_apart = Oracle(scene, i).least() > distance;
      apart_count += are_apart ? 1 : 0;
      if (spread[star.centre] == 0) continue;
      ++spread_count;
      ASSERT_TRUE(are_apart) << "round " << round << ", star " << i;
    }
  }
  EXPECT_GT(spread_count, 800) << "of " << apart_count << " without contacts";
}

/// A star in a plane, as seen along z, whose vertices lie at these angles, in degrees, 1 from the centre.
struct FlatStar {
  std::vector<Vec3f> x_t0, x_t1;
  VertexStar star{0, {}};
  std::vector<std::uint32_t> vertex_body;
  SceneBody body{};

  FlatStar(const std::vector<double>& angles, bool is_closed) {
    x_t1.push_back({0, 0, 0});
    for (const double degrees : angles) {
      const double angle = degrees * 3.14159265358979 / 180.0;
      x_t1.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0F});
    }
    x_t0 = x_t1;
    vertex_body.resize(x_t1.size(), 0);
    std::fill(std::begin(star.ring), std::end(star.ring), kNoIndex);
    for (std::uint32_t i = 0; i < angles.size(); ++i) star.ring[i] = i + 1;
    if (is_closed) star.ring[angles.size()] = 1;
    body.has_stars = true;
  }

  bool is_spread(float margin, bool is_swept) {
    body.margin = margin;
    SceneView view;
    view.x_t0 = x_t0.data();
    view.x_t1 = x_t1.data();
    view.vertex_body = vertex_body.data();
    view.bodies = &body;
    view.is_swept = is_swept;
    std::vector<std::uint8_t> vertices(x_t1.size(), 2);
    TestStar{view, &star, {vertices.data(), nullptr, nullptr}}(0);
    return vertices[0] != 0;
  }
};

TEST(VertexStars, stars_of_regular_meshes_are_spread) {
  const auto expect_spread = [](FlatStar star, float altitude) {
    for (const bool is_swept : {false, true}) {
      EXPECT_TRUE(star.is_spread(0.0F, is_swept));
      EXPECT_TRUE(star.is_spread(0.49F * altitude, is_swept));
      EXPECT_FALSE(star.is_spread(0.51F * altitude, is_swept));
    }
  };
  expect_spread(FlatStar({0, 60, 120, 180, 240, 300}, true), 0.866F);
  expect_spread(FlatStar({0, 90, 180, 270}, true), 0.5F * 1.41421356F);
  expect_spread(FlatStar({0, 60, 120, 180}, false), 0.866F);
  expect_spread(FlatStar({0, 90}, false), 0.5F * 1.41421356F);
  expect_spread(FlatStar({0, 60, 120, 180, 240}, false), 0.866F);
}

TEST(VertexStars, stars_that_turn_twice_are_not_spread) {
  EXPECT_FALSE(FlatStar({0, 90, 180, 270, 360, 450, 540, 630}, true).is_spread(0.0F, false));
  EXPECT_FALSE(FlatStar({0, 60, 120, 180, 240, 300, 359}, false).is_spread(0.0F, false));
  EXPECT_FALSE(FlatStar({0, 60, 120, 180, 240, 300, 390}, false).is_spread(0.0F, false));
  EXPECT_FALSE(FlatStar({0, 90, 180, 270, 360, 450}, false).is_spread(0.0F, false));
}

// At the start of the step the last vertex is nearer to the first than any altitude.
TEST(VertexStars, the_ends_of_an_open_star_may_meet) {
  const FlatStar at_t0({0, 70, 140, 210, 350}, false);
  FlatStar star({0, 70, 140, 210, 265}, false);
  EXPECT_TRUE(star.is_spread(0.15F, true));
  star.x_t0 = at_t0.x_t1;
  EXPECT_TRUE(star.is_spread(0.15F, false));
  EXPECT_FALSE(star.is_spread(0.15F, true));
}

// Half a turn on straight paths leads all vertices through the centre.
TEST(VertexStars, stars_are_not_spread_while_they_are_small) {
  FlatStar star({0, 60, 120, 180, 240, 300}, true);
  for (std::size_t v = 1; v < star.x_t0.size(); ++v) star.x_t0[v] = -star.x_t0[v];
  EXPECT_FALSE(star.is_spread(0.0F, true));
  for (Vec3f& x : star.x_t0) x = x + Vec3f{5.0F, -3.0F, 2.0F};
  EXPECT_FALSE(star.is_spread(0.0F, true));
}

TEST(VertexStars, positions_that_are_not_finite_or_at_one_point_are_not_spread) {
  for (const float bad : {std::nanf(""), HUGE_VALF, 1e37F}) {
    for (std::size_t v = 0; v < 7; ++v) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        FlatStar star({0, 60, 120, 180, 240, 300}, true);
        (&star.x_t1[v].x)[axis] = bad;
        EXPECT_FALSE(star.is_spread(0.0F, false));
        EXPECT_FALSE(star.is_spread(0.0F, true));
      }
    }
  }
  FlatStar point({0, 60, 120, 180, 240, 300}, true);
  std::fill(point.x_t1.begin(), point.x_t1.end(), Vec3f{1, 2, 3});
  EXPECT_FALSE(point.is_spread(0.0F, false));
}

}  // namespace
}  // namespace softcd::test
